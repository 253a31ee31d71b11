"""Names that `symdyn.study` offers; each is imported when it is first used."""

from .beside import beside as beside
from .design import DESIGNS as DESIGNS
from .door import open as open, sweep as sweep
from .first_order import uncertainty as uncertainty
from .indices import Indices as Indices, indices as indices
from .over import FORMS as FORMS
from .plots import PLOTS as PLOTS, check_study_plot as check_study_plot
from .store import SUFFIX as SUFFIX
from .study import Study as Study
