"""Names that `symdyn.scene.joints` offers; each is imported when it is first used."""

from .blocks import unit as unit
from .joint_kind import Gimbal as Gimbal, JointBlock as JointBlock, JointMotion as JointMotion, MarkPart as MarkPart
from .joint_table import JOINTS as JOINTS, joint_motion as joint_motion, start_of as start_of
