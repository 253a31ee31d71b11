"""Certificates: derivations proved equal, laws proved, built code measured against 50 digits."""

from symdyn.verify.accuracy import Accuracy, measure
from symdyn.verify.certificate import Certificate, certify
from symdyn.verify.equality import DIFFERENT, NUMERICAL, PROVED, Claim, Fields, Finding, prove
from symdyn.verify.law import Law, entries, everywhere, of_loops
from symdyn.verify.laws import LAWS, laws
from symdyn.verify.rigorous import Bound, Rigorous, rigorous
from symdyn.verify.written import Written

__all__ = [
    "DIFFERENT",
    "LAWS",
    "NUMERICAL",
    "PROVED",
    "Accuracy",
    "Bound",
    "Certificate",
    "Claim",
    "Fields",
    "Finding",
    "Law",
    "Rigorous",
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
