"""From the variant `literal` to the variant `paper`, one repair at a time: what the paper needs beyond its print.

Two ways to ask what a repair is for: made one after the other, and taken back alone from `paper`.
"""

from vpf_sim.planning.variants.ablation_steps import Change, Table, steps, taken_over

REPAIRS = (
    Change("flow", "flow: chained over 0.1 s, since one frame's flow is below a pixel at 60 Hz", ("flow",)),
    Change(
        "focus",
        "focus of expansion and time to contact: right closed form, without rotation and outliers",
        ("focus_of_expansion", "time_to_contact"),
    ),
    Change(
        "rotation",
        "total force: the rotation matrix is transposed, from vehicle to world axes",
        ("paper_planner.total_field.rotation",),
    ),
    Change(
        "axes",
        "total force: the image's x acts on the vehicle's Y; the sum of the times to contact is left out",
        ("paper_planner.total_field.axes", "paper_planner.obstacle_field.terms"),
    ),
    Change(
        "angles",
        "heading and target: atan2 for atan, the target's angle in vehicle axes",
        ("paper_planner.target_field.direction", "paper_planner.reference"),
    ),
    Change(
        "road",
        "road field: right curved form, which edges, lambda",
        ("paper_planner.road_field", "paper_planner.total_field.lambda_x", "paper_planner.total_field.lambda_y"),
    ),
    Change(
        "goal",
        "target field: the goal lies within reach, so that the weights do not change along the way",
        ("paper_planner.target_field.reach_m", "paper_planner.target_field.at"),
    ),
    Change(
        "obstacle-test",
        "obstacle map: what the road's own flow does not explain, instead of Otsu on the flow's length",
        ("obstacle_map.method",),
    ),
    Change("region", "obstacle map: the region of interest", ("obstacle_map.region",)),
    Change(
        "weights",
        "obstacle field: gamma, |R|, sigma, weight of a point",
        (
            *("paper_planner.obstacle_field.gamma", "paper_planner.obstacle_field.area"),
            *("obstacle_map.sigma_px", "obstacle_map.normalisation", "obstacle_map.weight"),
        ),
    ),
    Change("controller", "controller: low-passed rate of the heading reference; c_r, u_0", ("gains", "controller")),
)
MADE, WITHOUT = "repair-", "without-"  # before the name of a repair: all up to it are made; only it is taken back


def made(literal: Table, paper: Table) -> dict[str, tuple[str, Table]]:
    """Summary and table of each step from `literal` to `paper`, by its name."""
    return {f"{MADE}{name}": step for name, step in steps(literal, paper, REPAIRS).items()}


def taken_back(literal: Table, paper: Table) -> dict[str, tuple[str, Table]]:
    """Summary and table of `paper` without one repair, by its name; a repair that changes nothing is none."""
    found: dict[str, tuple[str, Table]] = {}
    for repair in REPAIRS:
        table = taken_over(paper, literal, repair)
        if table != paper:
            found[f"{WITHOUT}{repair.name}"] = (f"without {repair.summary}", table)
    return found
