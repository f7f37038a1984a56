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

/// Finds the control point at which a fingertip gets the most from a field. Each point takes a
/// fingertipForce(), because the pressures at the points don't tell what is between them; so a
/// field that moves gets few at a time, and one at rest all.
class FingertipSearch
{
public:
    /// Starts with \a sequence, played with \a achieved_Pa at each of \a points. Looks at the point
    /// with the strongest points around it, at the strongest one of the last field, and at \a most
    /// others, which take turns from field to field. Returns the strongest force; 0 without points,
    /// pressures or fields.
    FingertipForce begin(const ControlPoints& points,
                         const Eigen::VectorXd& achieved_Pa,
                         const TransducerArray& array,
                         const Medium& medium,
                         const FieldSequence& sequence,
                         bool isContact,
                         int most);
    /// Looks at up to \a most further points of the same field. Returns the strongest force so far.
    FingertipForce goOn(const ControlPoints& points,
                        const TransducerArray& array,
                        const Medium& medium,
                        const FieldSequence& sequence,
                        bool isContact,
                        int most);
    bool hasWork() const { return _left > 0; } ///< not all points were looked at
    void end() { _left = 0; }

private:
    void take(int point, const FingertipForce& force);

    int _best = 0; // index of the strongest point
    int _next = 0; // whose turn it is
    int _left = 0; // points of this field that were not looked at
    FingertipForce _most;
};

/// Returns the force at that of \a points at which a fingertip gets the most; \a achieved_Pa: the
/// pressure at each. It costs as much as the pressures of 61 places for each point.
FingertipForce strongestForce(const ControlPoints& points,
                              const Eigen::VectorXd& achieved_Pa,
                              const TransducerArray& array,
                              const Medium& medium,
                              const FieldSequence& sequence);

} // namespace midair::haptics
