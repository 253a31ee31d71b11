"""Names that `symdyn.identification` offers; each is imported when it is first used."""

from .calibration import Calibration as Calibration, calibrate as calibrate
from .excitation import Excitation as Excitation
from .exciting_motion import excite as excite
from .gains import Gain as Gain
from .identification import Identification as Identification
from .identified_scene import Identified as Identified, identified as identified, with_parameters as with_parameters
from .identify_logs import identify as identify
from .output_error import OutputFit as OutputFit, output_error as output_error
from .payload import Payload as Payload
from .regression import Regression as Regression
from .report import Outcome as Outcome, report as report
