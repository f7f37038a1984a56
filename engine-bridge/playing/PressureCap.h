#pragma once

#include "device/ArrayDevice.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/sequence/FieldSequence.h"

#include <Eigen/Core>

#include <functional>
#include <string>
#include <vector>

namespace midair::bridge
{

class EarBound;
class FieldBounds;

/// Places where a cap must hold: \a points (3 x n), for each of \a arrays, which describe the same
/// array with and without obstacles.
struct CappedPlaces
{
    const Eigen::Matrix3Xd& points;
    std::vector<const haptics::TransducerArray*> arrays; ///< at least one
    const haptics::Medium& medium;
    /// amplitudes will be lowered later, even if the device doesn't fade
    bool modulated = false;
    int threads = 1;
    base::StopToken stop = {};      ///< once requested, base::Stopped is thrown
    const EarBound* ears = nullptr; ///< ear limit that holds as well; null: none
};

/// The result of PressureCap::hold() for one signal: the factor that was applied, and the field.
struct CappedField
{
    /// 0 .. 1; factor on all amplitudes. 1: unchanged; 0: silenced, because no lower level keeps
    /// the cap.
    double factor = 1.0;
    Eigen::VectorXcf played;     ///< m, as the device plays it
    Eigen::VectorXf achieved_Pa; ///< n, |G q| of played, for the first of Where::arrays
};

/// Result of PressureCap::hold() for a sequence.
struct CappedDrives
{
    /// The exact bytes that keep the cap, to be sent unchanged; all silent if no level keeps it.
    std::vector<device::DriveSignal> drives;
    CappedField held; ///< the field of a sequence of one; else empty
};

/// Returns true if none of \a fields sounds.
bool isSilent(const std::vector<Eigen::VectorXcf>& fields);

/// Sound level with all sounding transducers at their lowest level.
struct LowestLevel
{
    double amplitude = 0.0; ///< of full drive; 0: the device plays nothing at any level
    /// Upper bound of the peak pressure at the loudest control point: with a higher cap this field
    /// can be played. 0: silence.
    double pressure_Pa = 0.0;
    /// The same at the loudest listening place, relative to the ear limit; 0: no limit.
    double ears = 0.0;
};

/// Settings to be raised for a silent field to sound, by the names that the reader of the message
/// knows.
struct SilenceRemedy
{
    std::string cap = "MaxPressure";
    std::string target = "Pressure or Loudness";
    std::string amplitude = "MaxAmplitude"; ///< for an amplitude cap below the lowest level
    std::string ears = "EarLimit";
};

/// Limits the peak pressure at control points: computes the field as the device plays it, in its
/// levels, and scales the whole drive down until no point exceeds the cap. If even the lowest level
/// is too loud, as with a board that is only on or off, fewer transducers play; the field is silent
/// if a single one exceeds the cap.
///
/// The cap also holds when the device lowers the amplitudes afterwards (ramp, thermal budget,
/// modulation). If all transducers have one amplitude, as by default, lower means less pressure. If
/// not, each is rounded separately, and a margin for that rounding is kept. Parts of the array that
/// may sound alone (DriveAbility::part) also keep the cap alone. The same factor enforces an ear
/// limit (CappedPlaces::ears): the stricter of both counts.
class PressureCap
{
public:
    using Play = std::function<Eigen::VectorXcf(const device::DriveSignal&)>;

    /// \a max_Pa: the cap, peak, over 0 and at most 1e6; throws base::InputError otherwise. \a play
    /// returns the activations (m) that a device of \a ability plays for a drive.
    PressureCap(double max_Pa, Play play, device::DriveAbility ability = {});

    double max_Pa() const { return _max_Pa; }

    using Where = CappedPlaces;

    /// Lowers the duties of \a signal as far as the cap requires. \a known: a field with known
    /// pressures (FieldBounds); may be empty.
    CappedField hold(const Where& where, device::DriveSignal& signal, CappedField known = {}) const;

    /// Lowers all of \a fields, which are played in turn, by one common factor, so that their
    /// ratios stay. Returns the factor; 0: silenced. Throws base::InputError for an activation that
    /// is not finite. \a drives: set to the bytes that keep the cap; may be null.
    double holdAll(const Where& where,
                   std::vector<Eigen::VectorXcf>& fields,
                   std::vector<device::DriveSignal>* drives = nullptr) const;

    /// Does the same for a sequence of one or more fields. Returns the played factor, the ratio of
    /// the root mean squares of the amplitudes, because levels are coarser than factors. Throws
    /// like holdAll(). \a capped may be null.
    double hold(const Where& where,
                haptics::FieldSequence& sequence,
                CappedDrives* capped = nullptr) const;
    /// Returns true if \a fields are nearer to the ear limit of \a where than to this cap.
    bool isForEars(const Where& where, const std::vector<Eigen::VectorXcf>& fields) const;
    /// Returns true if \a signals, played in turn unchanged, keep the ear limit of \a where, as
    /// hold() defines it.
    bool keepsToEars(const Where& where, const std::vector<device::DriveSignal>& signals) const;
    /// Returns the message for a factor below 1 that isn't 0.
    std::string message() const;

    /// Sets StopReason::SILENCED in \a report of fields that were \a wanted, if hold()
    /// (report.capFactor is 0) or the device's levels left nothing of them, and appends the reason
    /// and a remedy to its message. Returns the appended text. Does nothing and returns an empty
    /// text if the report already explains the silence.
    std::string tellOfSilence(const Where& where,
                              const std::vector<Eigen::VectorXcf>& wanted,
                              const SilenceRemedy& remedy,
                              haptics::SolveReport& report) const;

    /// Level of \a fields with all their sounding transducers at the device's lowest level, or with
    /// \a alone only the first of them.
    LowestLevel lowest(const Where& where,
                       const std::vector<Eigen::VectorXcf>& fields,
                       bool alone = false) const;

private:
    int lowestDuty(int transducers) const;
    std::string tellOfCap(const Where& where,
                          const std::vector<Eigen::VectorXcf>& wanted,
                          const SilenceRemedy& remedy) const;
    double thinOut(const FieldBounds& bounds,
                   std::vector<device::DriveSignal>& signals,
                   std::vector<CappedField>& fields) const;
    std::vector<CappedField> playedOf(const FieldBounds& bounds,
                                      const std::vector<device::DriveSignal>& signals,
                                      std::vector<double>& most_Pa,
                                      std::vector<double>* ears = nullptr) const;

    double _max_Pa;
    Play _play;
    device::DriveAbility _ability;
    float _coarsest; ///< largest change of an amplitude by rounding to levels
};

} // namespace midair::bridge
