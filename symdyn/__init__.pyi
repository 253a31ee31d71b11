"""Names that `symdyn` offers; each is imported when it is first used."""

from . import (
    bench as bench,
    draw as draw,
    dynamics as dynamics,
    emit as emit,
    errors as errors,
    graph as graph,
    identification as identification,
    linear as linear,
    program as program,
    runtime as runtime,
    scene as scene,
    simulation as simulation,
    study as study,
    teach as teach,
    transcription as transcription,
    verify as verify,
)
from .draw import animation as animation, film as film, picture as picture
from .dynamics import closed_form as closed_form
from .emit.print import equations as equations
from .errors import SymdynError as SymdynError
from .identification import calibrate as calibrate, identify as identify
from .linear import linearize as linearize
from .runtime import lambdify as lambdify, load as load
from .scene import Scene as Scene, example as example, read as read
from .simulation import (
    Feedback as Feedback,
    Problem as Problem,
    gait as gait,
    inverse as inverse,
    inverse_kinematics as inverse_kinematics,
    pid as pid,
    sensitivity as sensitivity,
    simulate as simulate,
)
from .study import ensemble as ensemble, sweep as sweep, uncertainty as uncertainty
from .transcription import collocation as collocation
from .verify import certify as certify

__version__: str
