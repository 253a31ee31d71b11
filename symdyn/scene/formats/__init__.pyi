"""Names that `symdyn.scene.formats` offers; each is imported when it is first used."""

from .inertias import possible as possible
from .mjcf import long_face as long_face
from .placing import printable_names as printable_names
from .xml import XmlElement as XmlElement
