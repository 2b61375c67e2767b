"""JUnit report of a verdict, which CI systems show: a test case for each property."""

from pathlib import Path

from junitparser import Error, Failure, JUnitXml, Skipped, TestCase, TestSuite

from passafe_services.tools.export.whole_file import whole_output
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.verdict import Verdict


def write_junit(path: Path, verdict: Verdict, log: Path) -> None:
    """Write the report; what stands at the path stays until the new one is whole.

    Args:
        path: The file.
        verdict: The verdict.
        log: The log that was reviewed, the name of the test suite.

    Raises:
        ExportError: It cannot be written.
    """
    suite = TestSuite(str(log))
    for name, entry in verdict.properties.items():
        case = TestCase(name, classname=verdict.scenario)
        if entry.holds is not True:
            case.result = [_result(entry)]
        suite.add_testcase(case)
    report = JUnitXml("passafe review")
    report.add_testsuite(suite)
    with whole_output(path) as unfinished:
        report.write(str(unfinished), pretty=True)


def _result(entry: Property) -> Error | Failure | Skipped:
    """Return the result of a property that does not hold: skipped if it is not required, an error if it is unknown."""
    worst = "unknown" if entry.worst is None else f"{entry.worst:.6g}"
    said = entry.note or f"{entry.requirement}: {worst}"
    if not entry.required:
        return Skipped(said)
    result = Error(said) if entry.holds is None else Failure(said)
    result.text = "\n".join(violation.text for violation in entry.violations)
    return result
