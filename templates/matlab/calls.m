% Answers calls until its input ends. A call is a line: the name of a function, then rows and columns of each argument;
% the doubles of all arguments follow, bit by bit, and one byte, since a line is read when something follows it. The
% answer is a line: how many doubles, which follow, or what is wrong.
crash_dumps_octave_core(false);
sighup_dumps_octave_core(false);
sigterm_dumps_octave_core(false);
while true
  line = fgetl(stdin);
  if ~ischar(line)
    break
  end
  words = strsplit(line, ' ');
  sizes = reshape(str2double(words(2:end)), 2, []);
  given = cell(1, columns(sizes));
  for k = 1:columns(sizes)
    given{k} = zeros(sizes(:, k).');
    if ~isempty(given{k})  % to read nothing is to read all there is
      given{k}(:) = fread(stdin, numel(given{k}), 'double=>double', 0, 'ieee-le');
    end
  end
  fread(stdin, 1);
  try
    result = feval(words{1}, given{:});
    fprintf('%d\n', numel(result));
    fwrite(stdout, result, 'double', 0, 'ieee-le');
  catch fault
    fprintf('%s\n', strrep(fault.message, "\n", ' '));
  end
  fflush(stdout);
end
