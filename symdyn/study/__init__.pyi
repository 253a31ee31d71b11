"""Names that `symdyn.study` offers; each is imported when it is first used."""

from .design import DESIGNS as DESIGNS
from .first_order import uncertainty as uncertainty
from .first_order_check import beside as beside
from .indices import Indices as Indices, indices as indices
from .plots import PLOTS as PLOTS, check_study_plot as check_study_plot
from .run_sweep import open as open, sweep as sweep
from .store import SUFFIX as SUFFIX
from .study import Study as Study
from .varied import FORMS as FORMS
