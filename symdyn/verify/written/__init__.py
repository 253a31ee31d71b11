"""The written file read back: its own text becomes operations again, which are proved to be the program's.

Nothing here knows how text is printed; `symdyn.emit` is not imported (a test holds that). A grammar that others wrote
(tree-sitter's, extra `prove`) gives the syntax tree of a file, and its language the meaning:

    read(text: Text) -> Reading

`Text` holds the tree, the functions that are wanted and a graph with symbols for the entries of their arguments. The
reader walks the functions statement by statement, as the language runs them, and returns for every wanted function what
each entry of its result is, as an expression on that graph; and which parts of the file it has read so. Then

- a construct it has no meaning for is refused (`Unread`, with line and words), never skipped: statements it does not
  know, names used before they are set or set twice, builtins that something hides, entries of the result written twice
  or never, arguments read after the result has been written where both may be the same array;
- operations are those of the language: precedence as the grammar gives it, integer division, the first index;
- a literal is the number of the type that it is read as (`Text.number`), exactly.

`straight_line.py` reads the expressions of all languages alike: names, numbers, signs, operators, calls, entries of
arrays. A language is a row of `Syntax`, what its grammar calls them and how it spells functions, and a class that
follows `Reader` with what it alone says: statements, where functions stand, how an index counts.

`proof.py` compares these expressions with the program, whose constants are rounded correctly to the type, over the
fields of the certificate: the entries of the results, and of all operations on the way the results, whatever their
signs, so that what is known of rounding holds of the file too. What no reader reads (sines, tiles, loops over blocks,
headers) is fixed text: it must be byte for byte that of a fresh file, comments left out.

Adding a language: such a row and class and `read` in a file of its own, and a row in `readers.py`; `javascript.py` is
one.
"""

from symdyn.verify.written.proof import Files, Printed, Written, printed, prove_texts, unshown
from symdyn.verify.written.readers import READERS, languages

__all__ = ["READERS", "Files", "Printed", "Written", "languages", "printed", "prove_texts", "unshown"]
