"""What headers of C and POSIX call theirs: `python -m tests.names_of_headers` writes the list that code avoids.

All that stands outside of brackets in the headers, as gcc and g++ open them, constants of enumerations, and macros.
Names that begin with an underscore are left out, since no scene and no function has one.
"""

from __future__ import annotations

import re
import subprocess
import sys
import textwrap
from collections.abc import Iterable
from pathlib import Path

OF_C = """assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg
stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar wctype"""

OF_POSIX = """aio arpa/inet cpio dirent dlfcn fcntl fmtmsg fnmatch ftw glob grp iconv langinfo libgen monetary mqueue
net/if netdb netinet/in netinet/tcp nl_types poll pthread pwd regex sched search semaphore spawn strings
sys/ipc sys/mman sys/msg sys/resource sys/select sys/sem sys/shm sys/socket sys/stat sys/statvfs sys/time
sys/times sys/types sys/uio sys/un sys/utsname sys/wait syslog tar termios unistd utime utmpx wordexp"""

NOT_IN_CPP = {"stdatomic", "tgmath", "threads"}
"""Headers that C++ has not, or in which others stand."""

TOKEN = re.compile(r'"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])*\'|\w+|\S')

FILE = Path(__file__).resolve().parent.parent / "templates" / "c" / "names_of_headers.txt"


def headers(language: str) -> list[str]:
    """Return the headers of C and POSIX that a language opens."""
    return [one for one in (OF_C + " " + OF_POSIX).split() if language == "c" or one not in NOT_IN_CPP]


def _outside(text: str) -> Iterable[str]:
    """Yield names that stand outside of brackets, and constants of enumerations."""
    inside: list[bool] = []  # of every open bracket, whether names in it are seen outside
    before = ["", "", "", ""]
    for token in TOKEN.findall(text):
        if token in "([{":
            inside.append(token == "{" and ("enum" in before or before[-1].startswith('"')))
        elif token in ")]}":
            inside = inside[:-1]
        elif all(inside):
            yield token
        before = [*before[1:], token]


def names_of(language: str) -> set[str]:
    """Return all names of a language's headers on this machine; there has to be gcc and g++."""
    text = "".join(f"#include <{one}.h>\n" for one in headers(language))
    command = [{"c": "gcc", "c++": "g++"}[language], "-x", language, "-D_GNU_SOURCE", "-E", "-P", "-"]
    seen, macros = (
        subprocess.run([*command, *more], input=text, capture_output=True, text=True, check=True).stdout
        for more in ((), ("-dM",))
    )
    found = {*_outside(seen), *re.findall(r"^#define (\w+)", macros, re.MULTILINE)}
    return {name for name in found if re.fullmatch(r"[A-Za-z]\w*", name)}


def main() -> None:
    """Write the list."""
    there = (
        {name for line in FILE.read_text().splitlines() if line[:1] != "#" for name in line.split()}
        if FILE.exists()
        else set()
    )
    every = sorted(there | names_of("c") | names_of("c++"))
    about = "# Names of the headers of C and POSIX; `python -m tests.names_of_headers` adds those of a machine.\n"
    FILE.write_text(about + textwrap.fill(" ".join(every), 120, break_on_hyphens=False) + "\n")
    print(f"{len(every)} names", file=sys.stderr)


if __name__ == "__main__":
    main()
