"""Certificates: derivations proved equal, laws proved, built code measured against 50 digits."""

from symdyn.verdict import DIFFERENT, HOLD, NOT_SHOWN, NUMERICAL, PROVED, Judged, Unclaimed
from symdyn.verify.accuracy import Accuracy, measure
from symdyn.verify.certificate import Certificate, certify
from symdyn.verify.equality import Claim, Fields, Finding, prove
from symdyn.verify.law import Law, entries, everywhere, of_loops
from symdyn.verify.laws import LAWS, laws
from symdyn.verify.rigorous import Bound, Rigorous, rigorous
from symdyn.verify.written import Written

__all__ = [
    "DIFFERENT",
    "HOLD",
    "LAWS",
    "NOT_SHOWN",
    "NUMERICAL",
    "PROVED",
    "Accuracy",
    "Bound",
    "Certificate",
    "Claim",
    "Fields",
    "Finding",
    "Judged",
    "Law",
    "Rigorous",
    "Unclaimed",
    "Written",
    "certify",
    "entries",
    "everywhere",
    "laws",
    "measure",
    "of_loops",
    "prove",
    "rigorous",
]
