#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/probe/Feeling.h"
#include "haptics/sequence/FieldSequence.h"

#include <Eigen/Core>

namespace midair::haptics
{

/// Force on a fingertip, and how strong it feels.
struct FingertipForce
{
    double force_N = 0.0; ///< mean over all fields; 0: nothing is played
    /// Amplitude of the force that alternates as fields are played in turn, 20 to 1000 times a
    /// second; 0: it doesn't.
    double alternating_N = 0.0;
    PlayedAs how = PlayedAs::HELD;
    double threshold_N = 0.0; ///< least force that is felt; 0: the published one

    /// Of the mean or the alternating force, whichever is felt stronger.
    Strength strength() const;
    const char* feeling() const { return strengthName(strength()); }
};

/// Returns the force on a fingertip's pad at \a place (array frame): on a disc of 7 mm radius that
/// faces \a normal (zero: the array's z) and reflects all sound, with the share that the ringing of
/// transducers takes. What the finger changes in the field isn't in it. 0 without fields. It is
/// CIRCLING if \a isContact, VIBRATING if \a sequence has a modulation of the amplitude, else HELD.
/// It costs as much as the pressures of 61 points.
FingertipForce fingertipForce(const Eigen::Vector3d& place,
                              const Eigen::Vector3d& normal,
                              const TransducerArray& array,
                              const Medium& medium,
                              const FieldSequence& sequence,
                              bool isContact);

/// Returns the force at that of \a points around which a fingertip covers the strongest points,
/// with \a achieved_Pa at each. The last \a foci points are those of contacts.
FingertipForce strongestForce(const ControlPoints& points,
                              const Eigen::VectorXd& achieved_Pa,
                              const TransducerArray& array,
                              const Medium& medium,
                              const FieldSequence& sequence,
                              int foci = 0);

} // namespace midair::haptics
