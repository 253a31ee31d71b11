"""Names that `symdyn.simulation` offers; each is imported when it is first used."""

from .arm_branches import Branches as Branches, inverse_kinematics as inverse_kinematics
from .columns import axes_of as axes_of, read_output as read_output
from .ensemble_task import RunBlock as RunBlock
from .equations.compiled_routines import compiled_entries as compiled_entries, opened as opened, points as points
from .equations.contact_modes import Impact as Impact, change_of as change_of, column_words as column_words
from .equations.controller import Feedback as Feedback, feedback_of as feedback_of, read_feedback as read_feedback
from .equations.linear_controllers import linear_law as linear_law, pid as pid
from .equations.linear_feedback import state_names as state_names
from .equations.linear_law import matrices_of as matrices_of
from .equations.variational import Flow as Flow
from .error_bars import Uncertainty as Uncertainty
from .forward import simulate as simulate
from .gait import Gait as Gait, gait as gait
from .initial import Start as Start
from .integrate import METHODS as METHODS
from .integrate.valueless import valueless as valueless
from .inverse_run import inverse as inverse
from .measures import Measure as Measure, Measures as Measures, measure_slopes as measure_slopes
from .natural_contacts import contact_checks as contact_checks
from .panels import CHECKS as CHECKS, write_picture as write_picture
from .prescribed.forces import Forces as Forces, read_forces as read_forces, read_motion as read_motion
from .prescribed.point_path import read_path as read_path
from .problem import Problem as Problem, Run as Run
from .read_ensemble import read_task as read_task
from .serial_arm import arm_of as arm_of
from .timed_runs import TimedRuns as TimedRuns
from .trajectory import Trajectory as Trajectory
from .variations import Sensitivity as Sensitivity, sensitivity as sensitivity
