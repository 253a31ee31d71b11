% Answers calls until its input ends. A call is a line: the name of a function, then rows and columns of each argument;
% the doubles of all arguments follow, bit by bit. The answer is a line: how many doubles, which follow, or what is wrong.
while true
  line = fgetl(stdin);
  if ~ischar(line)
    break
  end
  words = strsplit(line, ' ');
  sizes = reshape(str2double(words(2:end)), 2, []);
  given = cell(1, columns(sizes));
  for k = 1:columns(sizes)
    given{k} = reshape(fread(stdin, prod(sizes(:, k)), 'double=>double', 0, 'ieee-le'), sizes(:, k).');
  end
  try
    result = feval(words{1}, given{:});
    fprintf('%d\n', numel(result));
    fwrite(stdout, result, 'double', 0, 'ieee-le');
  catch fault
    fprintf('%s\n', strrep(fault.message, "\n", ' '));
  end
  fflush(stdout);
end
