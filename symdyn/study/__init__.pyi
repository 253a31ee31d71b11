"""Names that `symdyn.study` offers; each is imported when it is first used."""

from .bands import drawn_bands as drawn_bands
from .beside import beside as beside
from .design import DESIGNS as DESIGNS, SALTELLI as SALTELLI
from .distributions import DISTRIBUTIONS as DISTRIBUTIONS
from .door import open as open, sweep as sweep
from .error_bars import Uncertainty as Uncertainty
from .first_order import uncertainty as uncertainty
from .indices import Indices as Indices, indices as indices
from .over import TOLERANCE as TOLERANCE
from .plots import (
    PLOTS as PLOTS,
    SHARES as SHARES,
    check_study_plot as check_study_plot,
    drawn_study as drawn_study,
    plot as plot,
)
from .store import SUFFIX as SUFFIX
from .study import Study as Study
