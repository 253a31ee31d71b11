"""Certificates: derivations proved equal, laws proved, built code measured against 50 digits."""

from symdyn.verify.accuracy import Accuracy, measure
from symdyn.verify.certificate import Certificate, certify
from symdyn.verify.equality import DIFFERENT, NUMERICAL, PROVED, Claim, Fields, Finding, prove
from symdyn.verify.laws import laws
from symdyn.verify.rigorous import Bound, Rigorous, rigorous

__all__ = [
    "DIFFERENT",
    "NUMERICAL",
    "PROVED",
    "Accuracy",
    "Bound",
    "Certificate",
    "Claim",
    "Fields",
    "Finding",
    "Rigorous",
    "certify",
    "laws",
    "measure",
    "prove",
    "rigorous",
]
