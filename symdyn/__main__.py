"""`python -m symdyn` is the command line, and so is the command `symdyn`.

Importing takes longer than a hand needs for Ctrl-C. Until a command listens, and once it has said its last word, the
signal ends the process as it ends any other, without a traceback.
"""

from __future__ import annotations

import gc
import signal
import sys

_OURS = (signal.default_int_handler, signal.SIG_DFL)
"""Who starts a command in the background may have it ignored, and that stays."""


def _interrupted_in_silence(silence: bool) -> None:
    if signal.getsignal(signal.SIGINT) in _OURS:
        signal.signal(signal.SIGINT, signal.SIG_DFL if silence else signal.default_int_handler)


def main() -> int:
    """Run the command line and return its exit status."""
    _interrupted_in_silence(True)
    from symdyn.cli import main as run

    _interrupted_in_silence(False)
    try:
        return run()
    finally:
        _interrupted_in_silence(True)
        gc.freeze()  # on its way out Python walks all that is left once more, which is a tenth of a long run


if __name__ == "__main__":
    sys.exit(main())
