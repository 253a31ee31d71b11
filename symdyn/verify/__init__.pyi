"""Names that `symdyn.verify` offers; each is imported when it is first used."""

from .accuracy import Accuracy as Accuracy, measure as measure
from .certificate import Certificate as Certificate, certify as certify, finite as finite, of_files as of_files
from .equality import Claim as Claim, Fields as Fields, Finding as Finding, prove as prove
from .law import Law as Law, entries as entries, everywhere as everywhere, of_loops as of_loops
from .laws import LAWS as LAWS, laws as laws
from .laws_of_reactions import (
    drives_in_reactions as drives_in_reactions,
    momentum as momentum,
    power_of_reactions as power_of_reactions,
    solvable as solvable,
)
from .rigorous import Bound as Bound, Rigorous as Rigorous, rigorous as rigorous
from .texts import NOWHERE as NOWHERE, files_of as files_of, not_read_back as not_read_back
from .written.beside import taken_first as taken_first
from .written.proof import Written as Written, printed as printed, prove_texts as prove_texts, unshown as unshown
from .written.readers import READERS as READERS, languages as languages
