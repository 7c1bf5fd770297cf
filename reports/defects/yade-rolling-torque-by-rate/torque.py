# The constant torque of rolling is not constant: two spheres of 2 cm, held 0.1 mm deep, of which one
# turns at 1, then at 10 rad/s; the torque on it is read.
#
#     yade -n -x torque.py
#
# Expected mR |F_n| = 1e-4 m 10 N = 0.001 N m at both rates (ViscElMat with mRtype = 1; Zhou and others,
# Physica A 269, 536 (1999), equation 3). Found 0.001 and 0.01 N m by Yade 2023.02a. Cause:
# ViscoelasticPM.cpp has relAngVel.normalized(), which returns a unit vector that nothing takes, for
# relAngVel.normalize(): the torque is mR |F_n| w, with w in rad/s. mRtype = 2 has the same factor.
from yade import O, utils
from yade.wrapper import *

def torque(rate):
    O.reset()
    material = O.materials.append(ViscElMat(kn=2e5, cn=0, ks=1e4, cs=0, frictionAngle=0, mR=1e-4, mRtype=1))
    for x in (0.0, 0.0199):
        O.bodies.append(utils.sphere((x, 0, 0), 0.01, material=material, fixed=True))
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb()]),
        InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_ViscElMat_ViscElMat_ViscElPhys()], [Law2_ScGeom_ViscElPhys_Basic()]),
        NewtonIntegrator(damping=0),
    ]
    O.dt = 1e-9
    O.bodies[0].state.angVel = (0, rate, 0)
    O.step()
    return -O.forces.t(0)[1]

print(f"torque at 1 and 10 rad/s: expected 0.001 and 0.001 N m, found {torque(1):.3g} and {torque(10):.3g}")
