"""Names that `symdyn.verify` offers; each is imported when it is first used."""

from .accuracy import Accuracy as Accuracy, measure as measure
from .building import why_unread as why_unread
from .certificate import Certificate as Certificate, certify as certify, on_unit_sphere as on_unit_sphere
from .claims import Law as Law, entries as entries, everywhere as everywhere, of_loops as of_loops
from .equality import Claim as Claim, Fields as Fields, Finding as Finding, prove as prove
from .laws import LAWS as LAWS, claims_of_reactions as claims_of_reactions, laws as laws
from .rigorous import Bound as Bound, Rigorous as Rigorous, rigorous as rigorous
from .written.proof import Written as Written
