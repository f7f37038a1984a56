#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/scattering/Scatterer.h"

#include <Eigen/Core>

#include <memory>
#include <string>
#include <vector>

namespace midair::haptics
{

/// The field of an array with rigid things in it. Waves that one thing scatters to another are left
/// out. One call at a time.
class ScatteredField
{
public:
    /// \a things: at least one. \a array: with reflectors that aren't among \a things. Throws
    /// InputError for a transducer inside a thing.
    ScatteredField(std::vector<std::shared_ptr<const Scatterer>> things,
                   TransducerArray array,
                   const Medium& medium,
                   int threads = 1,
                   base::StopToken stop = {});

    /// Makes the drive \a q (m) that of the other functions; solves for each thing, unless it is
    /// that already. Throws Stopped.
    void setDrive(const Eigen::VectorXcf& q);
    /// Returns the pressures of the drive at \a points (3 x n, metres), Pa, without the things.
    Eigen::VectorXcd free_Pa(const Eigen::Matrix3Xd& points) const;
    /// Returns what the things add, Pa. Places inside one have no meaning.
    Eigen::VectorXcd scattered_Pa(const Eigen::Matrix3Xd& points) const;
    /// Returns at \a points what the true field has and that of \a array has not, Pa: all that the
    /// things add, or less if reflectors of \a array stand for them.
    Eigen::VectorXcd beyond_Pa(const Eigen::Matrix3Xd& points, const TransducerArray& array) const;
    /// Returns the part of scattered_Pa() that is known as a matrix (n x m: Scatterer::optics());
    /// null if no thing has one.
    std::shared_ptr<const Eigen::MatrixXcf> optics_Pa(const Eigen::Matrix3Xd& points) const;
    /// Returns "point 3 at (..) m is inside the body", or empty.
    std::string whyImpossible(const Eigen::Matrix3Xd& points) const;

    bool isInside(const Eigen::Vector3d& place) const; ///< a thing

    /// Largest numbers of all drives and things so far.
    const GmresReport& worst() const { return _worst; }
    Eigen::Index elements() const; ///< of all things

private:
    std::vector<std::shared_ptr<const Scatterer>> _things;
    TransducerArray _array;
    Medium _medium;
    int _threads;
    base::StopToken _stop;
    Eigen::VectorXcf _q;
    std::vector<Eigen::VectorXcd> _strengths; // of each thing
    GmresReport _worst;
};

} // namespace midair::haptics
