// Defines the kernels with their versions for the instruction sets; compiled once.
#include "haptics/propagation/kernels/LatticeKernels.h"
#include "haptics/propagation/kernels/MirroredRowKernels.h"
#include "haptics/propagation/kernels/PhaseKernels.h"
#include "haptics/propagation/kernels/PropagationKernels.h"
#include "haptics/propagation/kernels/ReflectionKernels.h"
#include "haptics/propagation/kernels/ShapingKernels.h"

namespace midair::haptics::kernels
{

MIDAIR_KERNEL_OF_THREE(buildCubic);
MIDAIR_KERNEL_OF_THREE(buildTable);
MIDAIR_KERNEL_OF_THREE(buildPoint);
MIDAIR_KERNEL(inverseRoots);
MIDAIR_KERNEL(packRow);
MIDAIR_KERNEL_OF_TWO(backward);
MIDAIR_KERNEL_OF_TWO(forward);
MIDAIR_KERNEL(projectToUnit);
MIDAIR_KERNEL(quantisePhase);
MIDAIR_KERNEL(formJacobian);
MIDAIR_KERNEL(transposedJacobian);
MIDAIR_KERNEL(applyJacobian);
MIDAIR_KERNEL(turn);
MIDAIR_KERNEL(compareDrives);
MIDAIR_KERNEL(innerProduct);
MIDAIR_KERNEL_OF_TWO(scaleBy);
MIDAIR_KERNEL(turnByDistance);

MIDAIR_KERNEL(buildMirroredCubic);
MIDAIR_KERNEL(buildMirroredTable);
MIDAIR_KERNEL(buildMirroredPoint);
MIDAIR_KERNEL(sharesTurned);
MIDAIR_KERNEL_OF_TWO(reflect);
MIDAIR_KERNEL(joinWaves);

MIDAIR_KERNEL(addGram);
MIDAIR_KERNEL_OF_TWO(multiplyMatrix);
MIDAIR_KERNEL_OF_TWO(descendOnce);
MIDAIR_KERNEL(bestTurn);

MIDAIR_KERNEL(jacobianColumns);
MIDAIR_KERNEL(shapeLevels);
MIDAIR_KERNEL(shapeCoarseLevels);
MIDAIR_KERNEL(phaseInLevels);
MIDAIR_KERNEL(unitAtLevel);

MIDAIR_KERNEL(marchLattice);
MIDAIR_KERNEL(nearestSquared);

} // namespace midair::haptics::kernels
