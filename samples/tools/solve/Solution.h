#pragma once

#include "engine-bridge/playing/EarBound.h"
#include "engine-bridge/solving/OneSolve.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/propagation/Exposure.h"
#include "haptics/scattering/ScatteredField.h"
#include "haptics/sequence/FieldSequence.h"
#include "haptics/surface/Outline.h"
#include "haptics/surface/TriangleMesh.h"
#include "samples/tools/solve/SolveFiles.h"
#include "samples/tools/solve/SolveOptions.h"

#include <osgMidair/ExposureFigures>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace midair::samples
{

/// Input of a solve: the array, the air and the model.
struct SolveScene
{
    haptics::TransducerArray array;
    haptics::Medium medium;
    haptics::TriangleMesh mesh; ///< metres; empty if the points come from a file
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< mesh -> array

    double wavelength_m() const { return medium.wavelength(array.frequency_Hz); }
};

/// Listening places of a solved field: those around the array, then those of a file.
class SolveEars
{
public:
    /// \a limit_dB: the ear limit; 0: none.
    SolveEars(const haptics::TransducerArray& array,
              const haptics::Medium& medium,
              const Eigen::Matrix3Xd& given,
              double limit_dB);

    /// Returns null if there is no limit.
    const bridge::EarBound* bound() const { return _bound.get(); }

    /// Returns the level at the loudest of the places for another array, or the same without its
    /// reflectors, in dB.
    double levelOf_dB(const haptics::TransducerArray& array,
                      const haptics::Medium& medium,
                      const std::vector<Eigen::VectorXcf>& fields) const;

    /// Returns the exposure at the loudest place while \a fields (K times m) play in turn without
    /// end.
    haptics::ExposureFigures figures(const std::vector<Eigen::VectorXcf>& fields) const;

    /// Writes x_m,y_m,z_m,L_dB,incoherent_dB: a row for each place of the file. L_dB is the level
    /// of the field as played, averaged over \a fields; incoherent_dB is the mean over all phases
    /// with the same amplitudes. Throws base::InputError.
    void write(const std::string& path, const std::vector<Eigen::VectorXcf>& fields) const;

private:
    Eigen::Index _given; ///< number of the file's places, which come last
    double _limit_dB;
    std::shared_ptr<haptics::Exposure> _exposure;
    std::unique_ptr<bridge::EarBound> _bound;
};

/// Signals of probes while a sequence repeats.
struct ProbeTraces
{
    double rate_Hz = 0.0;    ///< samples per second; the first is at time 0
    double ringing_s = 0.0;  ///< time constant of the transducers
    Eigen::Matrix3Xd points; ///< m, array frame
    /// complex envelope (peak) at the array's frequency for each point
    std::vector<Eigen::VectorXcd> pressure_Pa;
    Eigen::VectorXd steadyMean_Pa; ///< mean radiation pressure of the steady fields at each point
};

/// Writes into \a folder
///     probe.csv         point,time_s,p_re_Pa,p_im_Pa,radiation_Pa
///     spectrum.csv      point,frequency_Hz,radiation_Pa
///     probe_points.csv  point,x_m,y_m,z_m,mean_Pa,steadyMean_Pa
/// The spectrum is that of the radiation pressure: amplitudes, at 0 the mean. Throws
/// base::InputError.
void writeProbe(const std::string& folder,
                const ProbeTraces& traces,
                const haptics::Medium& medium);

/// All results that are written to files.
struct Solution : bridge::SolvedFields
{
    SolveScene scene;
    SummaryParts parts;
    std::optional<ProbeTraces> probe;                 ///< if requested
    std::optional<haptics::ToleranceStudy> tolerance; ///< if requested
    std::shared_ptr<haptics::ScatteredField> truth;   ///< with what scatters; null: nothing does
    haptics::TriangleMesh scatterer;                  ///< its shape, array frame, metres
    std::string scattererTold;                        ///< SolvedScatterer::what
    /// Returns |p| of activations (m) at places (3 x n), Pa, with what scatters, and 0 inside it;
    /// empty: nothing does.
    std::function<Eigen::VectorXf(const Eigen::Matrix3Xd& places, const Eigen::VectorXcf& q)>
        scattered_Pa;
    std::shared_ptr<const SolveEars> ears;
};

/// Samples the model, selects points, composes the fields, applies the cap and measures the result.
/// Throws base::InputError.
Solution solveAll(const SolveArguments& arguments);

} // namespace midair::samples
