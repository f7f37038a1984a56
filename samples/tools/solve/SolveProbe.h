#pragma once

#include "haptics/sequence/FieldSequence.h"
#include "samples/tools/solve/SolveOptions.h"
#include "samples/tools/solve/SolvePoints.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::samples
{

/// What probes have heard of a sequence that is played again and again.
struct ProbeTraces
{
    double rate_Hz = 0.0;    ///< samples per second; the first is at time 0
    double ringing_s = 0.0;  ///< time constant of the transducers
    Eigen::Matrix3Xd points; ///< m, array frame
    /// For each point the complex envelope at the array's frequency, peak
    std::vector<Eigen::VectorXcd> pressure_Pa;
    Eigen::VectorXd steadyMean_Pa; ///< of each point: mean radiation pressure of the steady fields
};

/// Returns true if the arguments ask for probes.
bool asksForProbes(const SolveArguments& arguments);

/// Returns the places that \a arguments name: those of --probe, then the control points, or the
/// surface's places within --probe-patch of a --probe. Throws base::InputError if there are none,
/// or more than 10^7 samples of all together.
Eigen::Matrix3Xd probePlaces(const SolveArguments& arguments,
                             const Eigen::Matrix3Xd& controlPoints,
                             const SolveScene& scene);

/// Probes \a sequence at \a places (3 x n). Throws base::InputError.
ProbeTraces probe(const SolveArguments& arguments,
                  const Eigen::Matrix3Xd& places,
                  const haptics::FieldSequence& sequence,
                  const SolveScene& scene);

/// Writes into \a folder
///     probe.csv         point,time_s,p_re_Pa,p_im_Pa,radiation_Pa
///     spectrum.csv      point,frequency_Hz,radiation_Pa
///     probe_points.csv  point,x_m,y_m,z_m,mean_Pa,steadyMean_Pa
/// The spectrum is that of the radiation pressure: amplitudes, at 0 the mean. Throws
/// base::InputError.
void writeProbe(const std::string& folder,
                const ProbeTraces& traces,
                const haptics::Medium& medium);

} // namespace midair::samples
