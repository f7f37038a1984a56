#pragma once

#include "engine-bridge/playing/EarBound.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/propagation/Exposure.h"

#include <osgMidair/ExposureFigures>

#include <Eigen/Core>

#include <memory>
#include <string>
#include <vector>

namespace midair::samples
{

/// Reads listening places (3 x n) from a CSV file with a header line that has x_m, y_m and z_m, in
/// any order; other columns are ignored. At most 100,000 places. Throws base::InputError that names
/// the file and the line.
Eigen::Matrix3Xd readEars(const std::string& path);

/// The places that hear a solved field: those around the array, then those of a file.
class SolveEars
{
public:
    /// \a limit_dB: the ear limit; 0: none.
    SolveEars(const haptics::TransducerArray& array,
              const haptics::Medium& medium,
              const Eigen::Matrix3Xd& given,
              double limit_dB);

    /// Null: there is no limit.
    const bridge::EarBound* bound() const { return _bound.get(); }

    /// Returns how loud \a fields (K times m), played in turn without end, are at the loudest
    /// place.
    haptics::ExposureFigures figures(const std::vector<Eigen::VectorXcf>& fields) const;

    /// Writes x_m,y_m,z_m,L_dB,incoherent_dB: a row for each place of the file. L_dB is of the
    /// field as played, in the place itself, averaged over \a fields; incoherent_dB is the mean
    /// over all phases of the same amplitudes. Throws base::InputError.
    void write(const std::string& path, const std::vector<Eigen::VectorXcf>& fields) const;

private:
    Eigen::Index _given; ///< number of the file's places, the last ones
    double _limit_dB;
    std::shared_ptr<haptics::Exposure> _exposure;
    std::unique_ptr<bridge::EarBound> _bound;
};

} // namespace midair::samples
