"""Names that `symdyn.simulation` offers; each is imported when it is first used."""

from .columns import FORCES as FORCES, Column as Column, unit_of as unit_of
from .ensemble.door import ensemble as ensemble
from .ensemble.ensemble import Ensemble as Ensemble
from .ensemble.measures import (
    FOLDS as FOLDS,
    Measure as Measure,
    Sums as Sums,
    fold_units as fold_units,
    read_measure as read_measure,
    read_measures as read_measures,
    sums_of as sums_of,
)
from .ensemble.one_by_one import sums_over as sums_over
from .equations.compiled_routines import argument as argument, compiled as compiled, plain as plain, points as points
from .equations.opened import opened as opened
from .equations.projection import Projection as Projection
from .equations.system import StateEquations as StateEquations
from .equations.variational import ALONG as ALONG, Flow as Flow, flow as flow
from .equations.written import state_equations as state_equations
from .feedback.controller import Feedback as Feedback, feedback_of as feedback_of, read_feedback as read_feedback
from .feedback.gains import Gains as Gains, state_names as state_names
from .feedback.saturation import Saturation as Saturation
from .forward import check_run as check_run, ready as ready, simulate as simulate
from .gradients import (
    Sensitivity as Sensitivity,
    check_smooth as check_smooth,
    independent as independent,
    sensitivity as sensitivity,
    starting as starting,
    varied as varied,
)
from .initial import Start as Start, Values as Values, read_guess as read_guess, read_start as read_start
from .integrate import METHODS as METHODS
from .integrate.heyoka_expressions import library as library, refuses as refuses, translate as translate
from .integrate.method import (
    IntegrationError as IntegrationError,
    Piece as Piece,
    Problem as Problem,
    importable as importable,
    integrate as integrate,
)
from .inverse_run import inverse as inverse
from .monitors import observe as observe
from .panels import Curve as Curve, Panel as Panel, check_columns as check_columns, chosen as chosen
from .plot import (
    check_plot as check_plot,
    plot as plot,
    write_picture as write_picture,
)
from .prescribed.forces import Forces as Forces, read_forces as read_forces
from .prescribed.path_entries import read_path as read_path
from .prescribed.point_path import ScenePath as ScenePath
from .prescribed.scene_motion import SceneMotion as SceneMotion, read_motion as read_motion
from .reaction_columns import axes_of as axes_of
from .record import (
    check_film as check_film,
    check_record as check_record,
    record as record,
    write_whole as write_whole,
)
from .tables import columns_csv as columns_csv, frame as frame
from .trajectory import END as END, INTERRUPTED as INTERRUPTED, Event as Event, Trajectory as Trajectory
from .variations import UNTOLD as UNTOLD, variations as variations
