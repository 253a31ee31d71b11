"""Names that `symdyn.simulation` offers; each is imported when it is first used."""

from .columns import FORCES as FORCES, Column as Column, unit_of as unit_of
from .ensemble.door import ensemble as ensemble
from .ensemble.ensemble import Ensemble as Ensemble
from .ensemble.measures import (
    FOLDS as FOLDS,
    Measure as Measure,
    fold_over as fold_over,
    read_measure as read_measure,
    read_measures as read_measures,
)
from .ensemble.one_by_one import measured as measured
from .equations.compiled_routines import argument as argument, compiled as compiled, plain as plain, points as points
from .equations.opened import opened as opened
from .equations.variational import Flow as Flow, flow as flow, smooth_flow as smooth_flow
from .equations.written import state_equations as state_equations
from .feedback.controller import Feedback as Feedback, feedback_of as feedback_of, read_feedback as read_feedback
from .feedback.gains import state_names as state_names
from .forward import check_run as check_run, simulate as simulate
from .gradients import Sensitivity as Sensitivity, sensitivity as sensitivity
from .initial import Start as Start, Values as Values, read_guess as read_guess, read_start as read_start
from .integrate import METHODS as METHODS
from .inverse_run import inverse as inverse
from .panels import check_columns as check_columns, chosen as chosen
from .plot import (
    check_plot as check_plot,
    plot as plot,
    write_picture as write_picture,
)
from .prescribed.forces import Forces as Forces, read_forces as read_forces
from .prescribed.scene_motion import SceneMotion as SceneMotion, read_motion as read_motion
from .reaction_columns import axes_of as axes_of
from .record import (
    check_film as check_film,
    check_record as check_record,
    record as record,
    write_whole as write_whole,
)
from .tables import columns_csv as columns_csv, frame as frame
from .timed_runs import Runs as Runs
from .trajectory import Trajectory as Trajectory
from .variations import UNTOLD as UNTOLD, variations as variations
