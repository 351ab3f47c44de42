"""What tests assert by themselves, with the reference that each has."""

from .commands import passed, test
from .report import Row, Table

ROUNDING, DIFFERENCES, CHANCE = "rounding", "what differences leave", "what chance allows"

# What, reference, tolerance, why, test.
TESTS = [
    ("exponential, logarithm, adjoint, right Jacobian", "group laws", "1e-11", ROUNDING, "--test laws se3"),
    (
        "Jacobian, all parameter blocks, three arms",
        "central differences, error falling as h²",
        "1e-9",
        DIFFERENCES,
        "--test jacobians kinematics",
    ),
    ("chain with all parameters folded", "parameterised chain", "1e-14 m", ROUNDING, "--test jacobians kinematics"),
    ("torques that bend an arm", "slope of the potential energy", "1e-8 N m", DIFFERENCES, "--test recovery joint_compliance"),
    (
        "compliances' derivatives, folded and re-read chains, estimates without noise",
        "differences; parameterised chain; truth",
        "1e-7; 1e-13 and 1e-12 m; 1e-9 rad/(N m)",
        "differences; rounding, in text too; the solver's last step",
        "--test recovery joint_compliance",
    ),
    ("gap of peg and hole", "parry3d", "1e-12 m", ROUNDING, "--test laws peg_in_hole_distance"),
    (
        "its gradient, slope through contact, near ties",
        "central differences; straight lines",
        "1e-7 of the row's size; 1e-9 m",
        DIFFERENCES,
        "--test jacobians peg_in_hole",
    ),
    ("least squares", "NIST's certified values", "7 digits", "condition numbers", "--lib nist"),
    ("gaps of meshes, their gradients", "parry3d; outlines of the same parts", "1e-9 m; as the tests say", ROUNDING, "--test laws mesh"),
    (
        "likelihood of contact modes",
        "differences; contacts drawn as it has them",
        "1e-4 of its scale; by chance",
        DIFFERENCES,
        "--lib contact_mode",
    ),
    ("the Cramér–Rao bound", "central differences", "1e-5", DIFFERENCES, "--test consistency campaign"),
    ("estimates without noise", "truth", "1e-9", "the solver's last step", "--test consistency coverage"),
    ("intervals of 40 simulated insertions", "truth", "coverage 92 to 98 %, NEES 6.1 to 9.9 of 8", CHANCE, "--test consistency coverage"),
    ("estimates from the MuJoCo logs", "truth", "as above", "as above", "--test recovery recorded_logs"),
    ("real arms, held-out placements", "sockets' means", "as above", "as above", "--test validation mukca_arms"),
    (
        "a real arm against a laser tracker; targets of simulated arms",
        "scipy on the same rows; truth",
        "3 % above, or below; 0.06 mm",
        "another loss; noise",
        "--test recovery targets",
    ),
    ("what cannot be determined is named", "constructed cases", "exact", "words", "--test recovery not_identifiable"),
    (
        "what is not usable is refused",
        "wrong minima, too few contacts, noise declared too small",
        "exact",
        "a verdict",
        "--test recovery not_usable",
    ),
    (
        "overlap at rest, also with friction; force on a plane; friction's bound; bending",
        "analytic cases",
        "1 µm; 1e-4; 1e-3; 2e-7 rad",
        "stiffness of the contact springs; the solver's last step",
        "--lib sim::",
    ),
    (
        "simulated logs: true poses, any number of threads",
        "analytic cases; each other",
        "1e-10; equal",
        "the solver's last step; sums in one order",
        "--test laws simulation",
    ),
    (
        "estimates with parts as meshes",
        "estimates with outlines of the same parts",
        "1e-6 to 0.05 standard deviations",
        "digits of the files; ties of nearly equal gaps",
        "--test recovery meshes",
    ),
    ("statistics of simulated logs", "the MuJoCo logs", "as above", "as above", "--test consistency simulator"),
]


def tables(_options):
    counts = {arguments: passed(test(*arguments.split())[1]) for arguments in dict.fromkeys(line[-1] for line in TESTS)}
    rows = []
    for what, reference, tolerance, why, arguments in TESTS:
        good, bad = counts[arguments]
        command = f"`cargo test --workspace {arguments}`"
        rows.append(
            Row(what, {"its tests passed": f"{good} of {good + bad}"}, reference, tolerance, why, command, bad > 0 or good == 0)
        )
    return [Table(rows)]
