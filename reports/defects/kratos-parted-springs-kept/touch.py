# Two spheres that part and touch again have the spring of their last contact: of two of 2 cm, pressed
# 0.1 mm, the upper one is moved 0.05 mm along the surface, lifted 0.2 mm and put back; the force along
# the surface is read.
#
#     python touch.py      with KratosMultiphysics and KratosDEMApplication
#     python touch.py 1    with a new search for neighbours each step, not each 50 (the default)
#
# Expected -0.006 N, a part of the normal force: the second contact is a new one. Found -1.595 N with
# Kratos 10.4.4, the force of the first; -0.006 N with a new search each step. Cause: spheric_particle.cpp,
# ComputeBallToBallContactForceAndMoment leaves mNeighbourElasticContactForces until the next search.
import sys, KratosMultiphysics as core, KratosMultiphysics.DEMApplication as dem
get, kinds = lambda name: core.KratosGlobals.GetVariable(name), ("DoubleVariable", "IntegerVariable", "Array1DVariable3", "DoubleQuaternionVariable")
every = [v for m in (core, dem) for v in vars(m).values() if type(v).__name__ in kinds]
values = {"STATIC_FRICTION": 1e9, "DYNAMIC_FRICTION": 1e9, "YOUNG_MODULUS": 1e7, "POISSON_RATIO": 0.3, "FRICTION_DECAY": 0.0, "ROLLING_FRICTION": 0.0, "COEFFICIENT_OF_RESTITUTION": 0.0, "DAMPING_GAMMA": 0.0, "PARTICLE_DENSITY": 2500.0, "NODAL_MASS_COEFF": 1.0, "SEARCH_RADIUS_INCREMENT": 0.01, "DELTA_TIME": 1e-4, "COMPUTE_WEAR": False, "ROTATION_OPTION": 1, "SEARCH_CONTROL": 1}
search = int(sys.argv[1]) if sys.argv[1:] else 50
model, s = core.Model(), dem.ExplicitSolverSettings()
parts = [model.CreateModelPart(name) for name in ("SpheresPart", "ContactPart", "RigidFacePart", "DEMInletPart", "ClusterPart")]
s.r_model_part, s.contact_model_part, s.fem_model_part, s.inlet_model_part, s.cluster_model_part = parts
for v in every: parts[0].AddNodalSolutionStepVariable(v); parts[2].AddNodalSolutionStepVariable(v)
sphere, pair = parts[0].CreateNewProperties(1), core.Properties(1)
for made in (sphere, pair, parts[0].ProcessInfo):
    for name, value in values.items(): made[get(name)] = value
dem.DEM_D_Linear_viscous_Coulomb().SetConstitutiveLawInProperties(pair, False); sphere.AddSubProperties(pair)
dem.VelocityVerletScheme().SetTranslationalIntegrationSchemeInProperties(sphere, False)
dem.VelocityVerletScheme().SetRotationalIntegrationSchemeInProperties(sphere, False)
dem.DEMGlobalDampingNonViscousCstForceDir().SetGlobalDampingModelInProperties(sphere, False)
nodes = [parts[0].CreateNewNode(k, 0.0, 0.0, height) for k, height in ((1, 0.0), (2, 0.0199))]
for k, node in enumerate(nodes, 1): parts[0].CreateNewElement("SphericParticle3D", k, [k], sphere); node.SetSolutionStepValue(core.RADIUS, 0, 0.01)
for name in [f"{v}VELOCITY_{axis}" for v in ("", "ANGULAR_") for axis in "XYZ"]:
    core.VariableUtils().AddDof(get(name), parts[0]); [node.Fix(get(name)) for node in nodes]
solver = dem.IterativeSolverStrategy(s, 1e-4, search, 1.0, 1, dem.ParticleCreatorDestructor(), dem.DEM_FEM_Search(), dem.OMP_DEMSearch(), core.Parameters('{"strategy": "sphere_strategy", "do_search_dem_neighbours": true, "do_search_fem_neighbours": false, "RemoveBallsInitiallyTouchingWalls": false, "model_import_settings": {}, "material_import_settings": {}}'))
solver.RebuildListOfDiscontinuumSphericParticles(); solver.SetNormalRadiiOnAllParticlesBeforeInitilization(parts[0])
solver.SetSearchRadiiOnAllParticles(parts[0], 0.01, 1.0); solver.Initialize()
def step(x, z):
    for name, speed in (("VELOCITY_X", x), ("VELOCITY_Z", z)): nodes[1].SetSolutionStepValue(get(name), 0, speed)
    parts[0].ProcessInfo[get("TIME_STEPS")] += 1
    solver.SolveSolutionStep()
    return nodes[1].GetSolutionStepValue(get("TOTAL_FORCES_X"))
*_, force = step(0.5, 0.0), step(0.0, 2.0), step(0.0, -2.0)
print(f"force along the surface: expected -0.006 N, found {force:.3f} N")
