"""
What if joints open as they slide?
==================================

Classical limit analysis assumes that a sliding joint opens by tan φ for each unit of slip. Real joints open
less, or not at all. In this example stone A is pulled out from under stone B, whose other end rests on a
rough support. By how much does the assumption raise the load factor?
"""

import masonry_opt as mo

FRICTION = 0.1


def pulled_out(dilatancy: float) -> mo.Scene:
    """Return the scene of Fig. 6 of Gilbert, Casapulla & Ahmed (2006): stone A under one end of stone B."""
    return mo.Scene(
        title="a stone pulled out",
        joints=mo.JointDefaults(friction=FRICTION, dilatancy=dilatancy),
        blocks=[
            mo.Block(name="A", vertices=[(2, 0), (5, 0), (5, 1), (2, 1)], weight=1, live=(1, 0)),
            mo.Block(name="B", vertices=[(0, 1), (3, 1), (3, 2), (0, 2)], weight=1),
            mo.Block(name="floor", vertices=[(2, -1), (9, -1), (9, 0), (2, 0)], fixed=True),
            mo.Block(name="rough", vertices=[(0, 0), (1, 0), (1, 1), (0, 1)], fixed=True),
        ],
        exceptions=[mo.Joint(between=("B", "rough"), friction=float("inf"))],
    )


# %%
# Both stones weigh 1. Without dilatancy B sinks while A slides, and presses on A with a quarter of its
# weight. Friction is then 1.25 μ below A and 0.25 μ above A, and λ = 1.5 μ. With any dilatancy, however
# small, B rises about its support and presses on A with three quarters of its weight, so that λ = 2.5 μ.
for dilatancy in (0.0, 0.01, 0.05, FRICTION):
    result = mo.solve(pulled_out(dilatancy))
    print(f"tan φ₀ = {dilatancy:.2f}: load factor {result.load_factor:.4f}")
assert abs(result.required() - 2.5 * FRICTION) < 1e-6

# %%
# The picture shows the mechanism under Coulomb's law, without dilatancy:
result = mo.solve(pulled_out(0.0))
assert abs(result.required() - 1.5 * FRICTION) < 1e-6
result.plot()
