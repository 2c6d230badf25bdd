"""Bodies linked in a tree, one by each kind of joint."""

import numpy as np
from scenes import bodies_at, random_pose

from snapfit.models.joint import JointMotion
from snapfit.models.manifest import Joint, JointType, Link
from snapfit.tracking.kinematics import KinematicStructures

PARENTS = (-1, 0, 0, 1, 1, 3)
TYPES = (None, "fixed", "revolute", "prismatic", "cylindrical", "screw")


def joint_of(rng: np.random.Generator, kind: str, **limits: tuple[float, float]) -> JointMotion:
    axis = {} if kind == "fixed" else {"axis": tuple(rng.normal(size=3))}
    if kind not in ("fixed", "prismatic"):
        axis["point_m"] = tuple(rng.normal(scale=0.05, size=3))
    pitch = {"pitch_m": 0.02} if kind == "screw" else {}
    joint = Joint(type=JointType(kind), **axis, **pitch, **limits)
    return JointMotion.of(
        Link(parent="a", child="b", parent_from_child=random_pose(rng), joint=joint)
    )


def tree(rng: np.random.Generator, **limits: tuple[float, float]) -> tuple:
    """Six bodies, each by another joint; every body has an energy of its own."""
    structures = KinematicStructures(len(PARENTS))
    poses = [random_pose(rng) for _ in PARENTS]
    for child, (parent, kind) in enumerate(zip(PARENTS, TYPES, strict=True)):
        if kind is not None:
            joint = joint_of(rng, kind, **(limits if kind == "prismatic" else {}))
            structures.link(child, parent, joint, rng.uniform(-0.01, 0.01, joint.n_dof))
    bodies = bodies_at(poses)
    structures.place(0, bodies.poses)
    for body in range(len(PARENTS)):
        jacobians = rng.normal(size=(20, 6)) * [50, 50, 50, 1000, 1000, 1000]
        bodies.hessians[body] = np.tril(jacobians.T @ jacobians)
        bodies.gradients[body] = rng.normal(size=6) * [100, 100, 100, 3000, 3000, 3000]
    return structures, bodies
