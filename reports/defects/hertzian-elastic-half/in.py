# HertzianElastic has three quarters of Hertz's force: two spheres of 2 cm at rest overlap by 10 um.
#
#     mpirun.openmpi -np 2 esysparticle in.py
#
# Expected 0.163815 N, 4/3 E* sqrt(R*) overlap^(3/2). Found 0.122861 N, 3/4 of it, by 2.3.4 (Debian's
# package of 2.3.5). Cause: HertzianElasticInteraction.cpp multiplies
# E sqrt(R) / (1 - nu^2) by 1/2 in place of 2/3; HertzianViscoElastic has 2/3.
from __future__ import print_function

from esys.lsm import HertzianElasticPrms, LsmMpi, RotSphere
from esys.lsm.util import BoundingBox, Vec3

radius, mass, overlap, step = 0.01, 0.0105, 1e-5, 1e-8
modulus, poisson = 1e8, 0.3
# E* = E / 2 / (1 - nu^2), R* = radius / 2
reduced = modulus / 2.0 / (1.0 - poisson**2)
expected = 4.0 / 3.0 * reduced * (0.5 * radius) ** 0.5 * overlap**1.5

sim = LsmMpi(numWorkerProcesses=1, mpiDimList=[1, 1, 1])
sim.initNeighbourSearch(particleType="RotSphere", gridSpacing=0.05, verletDist=0.002)
sim.setSpatialDomain(BoundingBox(Vec3(-0.5, -0.5, -0.5), Vec3(0.5, 0.5, 0.5)))
sim.setTimeStepSize(step)
sim.setNumTimeSteps(3)
for number, place in enumerate((radius - 0.5 * overlap, 0.5 * overlap - radius), 1):
    sim.createParticle(RotSphere(id=number, posn=Vec3(0.0, 0.0, place), radius=radius, mass=mass))
sim.createInteractionGroup(
    HertzianElasticPrms(name="contact", E=modulus, nu=poisson)
)
speeds = []
for _ in range(2):
    sim.runTimeStep()
    speeds.append(sim.getParticleList([1])[0].getLinearVelocity()[2])
found = mass * (speeds[1] - speeds[0]) / step
print("force (N): expected %.6f, found %.6f" % (expected, found))
sim.exit()
