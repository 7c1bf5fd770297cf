"""The grain from event to event: hops that die out into sliding, sliding that ends in a shock."""

from __future__ import annotations

import math

from harness.compiled import compiled
from harness.hard_sphere.motion import LEAVES, SHOCK, flight, slide

COLLAPSED = 1e-8
"""[sqrt(g d)] Speed of a rebound from which on the hops add up to sliding: they take a time of
2 v / (N (1 - e)) in all, in which the grain moves along the sphere as if it slid, but for terms of
the order of v^2."""

MOST_EVENTS = 1_000_000

MOVES_ON, TRAPPED, UNDECIDED = 1, 0, -1


@compiled
def follow(
    x: float, y: float, vx: float, vy: float, theta: float, e: float, wells: int, settle: bool
) -> tuple[int, float, int, bool, float]:
    """Follow the grain over ``wells`` crests, or until it has too little energy for the next.

    Position and velocity in units of d and sqrt(g d), theta in radians, x from the centre of
    sphere 0 whose crest lies behind. Return its fate, the energy above that of rest on the crest
    ahead [m g d], the number of collisions, whether it slid at the end, and the angle ahead of a
    crest [rad] at which its hops died out last (NaN: never). With ``settle`` a grain that will not
    pass is followed until its hops have died out: its energy is what is left then.
    """
    sine, cosine = math.sin(theta), math.cos(theta)
    crest, left, hits, settled = 1, -(10**9), 0, math.nan
    for _ in range(MOST_EVENTS):
        t, sphere = flight(x, y, vx, vy, theta, left)
        if not math.isfinite(t):
            break
        x, y = x + vx * t + 0.5 * sine * t * t, y + vy * t - 0.5 * cosine * t * t
        vx, vy = vx + sine * t, vy - cosine * t
        energy = 0.5 * (vx * vx + vy * vy) + y * cosine - x * sine
        while x > crest - sine:
            if crest == wells:
                return MOVES_ON, energy - 1.0 + crest * sine, hits, False, settled
            crest += 1
        nx, ny = x - sphere, y
        size = math.hypot(nx, ny)
        nx, ny = nx / size, ny / size
        into, hits = -(vx * nx + vy * ny), hits + 1
        along = vx * ny - vy * nx
        beta = math.atan2(nx, ny) + theta
        if e * into > COLLAPSED or math.cos(beta) <= along * along:
            vx, vy, left = vx + (1.0 + e) * into * nx, vy + (1.0 + e) * into * ny, sphere
            energy = 0.5 * (vx * vx + vy * vy) + y * cosine - x * sine
            if energy < 1.0 - crest * sine and not settle:
                return TRAPPED, energy - 1.0 + crest * sine, hits, False, settled
            continue
        # it slides, turning round where it comes to rest, until it flies or meets a sphere
        own = 0.5 * along * along + math.cos(beta)
        forward, ends, settled = along >= 0.0, -1, beta
        over = own - sphere * sine - 1.0 + crest * sine
        if over < 0.0:
            return TRAPPED, over, hits, True, settled
        if forward and sphere >= crest and beta <= 0.0:
            if crest == wells:
                return MOVES_ON, over, hits, True, settled
            crest += 1
        while ends not in (LEAVES, SHOCK):
            beta, ends = slide(own, beta, forward, theta)
            forward = forward if ends in (LEAVES, SHOCK) else not forward
        speed = math.sqrt(max(0.0, 2.0 * (own - math.cos(beta)))) * (1.0 if forward else -1.0)
        phi = beta - theta
        x, y = sphere + math.sin(phi), math.cos(phi)
        vx, vy, left = speed * math.cos(phi), -speed * math.sin(phi), sphere
    return UNDECIDED, 0.0, hits, False, settled
