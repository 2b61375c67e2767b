"""Prints the verification of a log to the terminal."""

from collections import Counter
from typing import Final

from rich.console import Console

from passafe_services.cli.log_time import log_time
from passafe_services.log.verification import Verification

_SHOWN: Final = 20


def print_verification(verification: Verification) -> None:
    """Print who signed a log, what is attested, and what speaks against it."""
    console = Console(highlight=False, soft_wrap=True, markup=False)
    for each in verification.found[:_SHOWN]:
        console.print(f"differs   {each.change}: {each.key} {each.sequence} of {log_time(each.wall_ns)}")
    if verification.found_in_all > _SHOWN:
        counts = Counter(each.change for each in verification.found)
        said = ", ".join(f"{number} {change}" for change, number in counts.items())
        console.print(f"differs   {verification.found_in_all} messages in all ({said})")
    for doubt in verification.doubts:
        console.print(f"doubt     {doubt}")
    if verification.signer:
        trust = "" if verification.is_pinned else "; the authority is the log's own word: name yours with --authority"
        console.print(f"signed    by {verification.signer}, certificate {verification.fingerprint}{trust}")
    outcome = "verified" if verification.holds else "not verified"
    console.print(
        f"{outcome}: {verification.attested} of {verification.messages} messages are as "
        f"{verification.checkpoints} checkpoints attest"
    )
