"""The archive that an FMU is: the same members, the same bytes; stored as they are, since packers differ."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping

BIRTHDAY = (1980, 1, 1, 0, 0, 0)
"""When every member was written: no date reaches a file."""


def packed(files: Mapping[str, str | bytes]) -> bytes:
    """Return files as an archive, in their order."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, contents in files.items():
            member = zipfile.ZipInfo(name, BIRTHDAY)
            member.create_system = 3
            member.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(member, contents)
    return stream.getvalue()
