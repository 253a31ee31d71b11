"""What a file holds, never more than a bound: a device without an end, or a film by mistake, fills no memory."""

from __future__ import annotations

from pathlib import Path

from symdyn.errors import SceneError

BEGIN = "check the path, or begin a scene with symdyn new"
"""What to do where there is no scene."""


def read_bounded(path: Path, most: int, wanted: str, advice: str, missing: str = "check the path") -> bytes:
    """Return the contents of a file of at most `most` bytes.

    Args:
        path: of the file.
        most: a multiple of 2**20.
        wanted: what kind of file, such as "a scene file".
        advice: behind the message that the file is larger.
        missing: behind the message that there is none.

    Raises:
        SceneError: it cannot be read, and why, or holds more.
    """
    try:
        with path.open("rb") as file:
            content = file.read(most + 1)
    except FileNotFoundError:
        raise SceneError(f"{path}: there is no such file; {missing}") from None
    except IsADirectoryError:
        raise SceneError(f"{path}: is a folder; give {wanted}") from None
    except (OSError, ValueError) as error:
        raise SceneError(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})") from None
    if len(content) > most:
        raise SceneError(f"{path}: holds more than {most >> 20} MB; {advice}")
    return content
