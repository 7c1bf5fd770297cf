# RotElastic forgets scaling=False: two spheres of 2 cm at rest overlap by 10 um.
#
#     mpirun.openmpi -np 2 esysparticle in.py
#
# Expected 1 N, k overlap. Found 0.01 N, k times the mean radius in m times the overlap, by 2.3.4
# (Debian's package of 2.3.5). Cause: RotElasticPrms takes scaling=False, but workers are told its
# stiffness alone (Parallel/SubLattice.hpp, RotElastic), and scale it.
from __future__ import print_function

from esys.lsm import RotElasticPrms, LsmMpi, RotSphere
from esys.lsm.util import BoundingBox, Vec3

radius, mass, overlap, step = 0.01, 0.0105, 1e-5, 1e-8
stiffness = 1e5
expected = stiffness * overlap

sim = LsmMpi(numWorkerProcesses=1, mpiDimList=[1, 1, 1])
sim.initNeighbourSearch(particleType="RotSphere", gridSpacing=0.05, verletDist=0.002)
sim.setSpatialDomain(BoundingBox(Vec3(-0.5, -0.5, -0.5), Vec3(0.5, 0.5, 0.5)))
sim.setTimeStepSize(step)
sim.setNumTimeSteps(3)
for number, place in enumerate((radius - 0.5 * overlap, 0.5 * overlap - radius), 1):
    sim.createParticle(RotSphere(id=number, posn=Vec3(0.0, 0.0, place), radius=radius, mass=mass))
sim.createInteractionGroup(
    RotElasticPrms(name="contact", normalK=stiffness, scaling=False)
)
speeds = []
for _ in range(2):
    sim.runTimeStep()
    speeds.append(sim.getParticleList([1])[0].getLinearVelocity()[2])
found = mass * (speeds[1] - speeds[0]) / step
print("force (N): expected %.6f, found %.6f" % (expected, found))
sim.exit()
