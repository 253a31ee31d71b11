"""Certificates: derivations proved equal, laws proved, built code measured against 50 digits."""

from symdyn.verify.accuracy import Accuracy, measure
from symdyn.verify.certificate import Certificate, certify
from symdyn.verify.equality import DIFFERENT, NUMERICAL, PROVED, Claim, Fields, Finding, prove
from symdyn.verify.laws import laws

__all__ = [
    "DIFFERENT",
    "NUMERICAL",
    "PROVED",
    "Accuracy",
    "Certificate",
    "Claim",
    "Fields",
    "Finding",
    "certify",
    "laws",
    "measure",
    "prove",
]
