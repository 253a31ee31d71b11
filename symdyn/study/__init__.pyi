"""Names that `symdyn.study` offers; each is imported when it is first used."""

from .design import DESIGNS as DESIGNS, Indices as Indices
from .distributions import FORMS as FORMS, check_unbound as check_unbound
from .first_order import beside as beside, uncertainty as uncertainty
from .job_of_runs import ensemble as ensemble
from .plots import PLOTS as PLOTS, check_study_plot as check_study_plot
from .run_sweep import open as open, sweep as sweep
from .runs import Runs as Runs
from .store import SUFFIX as SUFFIX
