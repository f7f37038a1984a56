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

/// Where a cap must hold: at \a points (3 x n), for each of \a arrays, which describe the same
/// array with and without obstacles in the sound's way.
struct CappedPlaces
{
    const Eigen::Matrix3Xd& points;
    std::vector<const haptics::TransducerArray*> arrays; ///< at least one
    const haptics::Medium& medium;
    /// amplitudes will be lowered later, even if the device doesn't fade
    bool modulated = false;
    int threads = 1;
    base::StopToken stop = {};      ///< once requested, base::Stopped is thrown
    const EarBound* ears = nullptr; ///< a limit at listening places that holds as well; null: none
};

/// The result of PressureCap::hold() for one signal: the factor that was applied, and the field.
struct CappedField
{
    /// 0 .. 1; applied to all amplitudes. 1: unchanged; 0: silenced, since no lower level keeps to
    /// the cap.
    double factor = 1.0;
    Eigen::VectorXcf played;     ///< m, as the device plays it
    Eigen::VectorXf achieved_Pa; ///< n, |G q| of played, for the first of Where::arrays
};

/// What PressureCap::hold() makes of a sequence.
struct CappedDrives
{
    /// The very bytes that keep to the cap, to be sent as they are; all silent if nothing does.
    std::vector<device::DriveSignal> drives;
    CappedField held; ///< what a sequence of one field plays; else empty
};

/// Returns true if nothing sounds in any of \a fields.
bool isSilent(const std::vector<Eigen::VectorXcf>& fields);

/// What is heard while all transducers that sound do so at their lowest level.
struct LowestLevel
{
    double amplitude = 0.0; ///< of full drive; 0: the device plays nothing at any level
    /// Bound on the peak pressure at the loudest control point, as for a cap: a cap above it lets
    /// this field be played. 0: nothing sounds.
    double pressure_Pa = 0.0;
    /// The same at the loudest listening place, times the ear limit; 0: there is none.
    double ears = 0.0;
};

/// The setting that has to be raised for a silent field to sound, as whoever reads the message
/// knows it.
struct SilenceRemedy
{
    std::string cap = "MaxPressure";
    std::string target = "Pressure or Loudness";
    std::string amplitude = "MaxAmplitude"; ///< where nothing sounds below its cap
    std::string ears = "EarLimit";
};

/// Limits the peak pressure at control points: computes the field as the device plays it, in its
/// levels, and scales the whole drive down until no point exceeds the cap. Where even the lowest
/// level of all is too much, as of a board that is on or off, fewer transducers play; it is silent
/// if one alone exceeds the cap.
///
/// The cap also holds when the device lowers the amplitudes afterwards (ramp, thermal budget,
/// modulation). If all transducers have one amplitude, as by default, a lower one means less
/// pressure. If not, each is rounded by itself, and a margin for that rounding is kept. Parts of
/// the array that may sound alone (DriveAbility::part) keep to the cap alone too. An ear limit
/// (CappedPlaces::ears) is kept by the same factor: the stricter of both counts.
class PressureCap
{
public:
    using Play = std::function<Eigen::VectorXcf(const device::DriveSignal&)>;

    /// \a max_Pa: the cap, peak, over 0 and at most 1e6; throws base::InputError otherwise. \a play
    /// returns what a device of \a ability plays of a drive, as activations (m).
    PressureCap(double max_Pa, Play play, device::DriveAbility ability = {});

    double max_Pa() const { return _max_Pa; }

    using Where = CappedPlaces;

    /// Lowers the duties of \a signal as far as needed to keep to the cap. \a known: a field whose
    /// pressures are known (FieldBounds); may be empty.
    CappedField hold(const Where& where, device::DriveSignal& signal, CappedField known = {}) const;

    /// Lowers all of \a fields, which are played in turn, by one common factor, so that their
    /// ratios stay. Returns the factor; 0: silenced. Throws base::InputError for an activation that
    /// is not finite. \a drives: set to the bytes that keep to the cap; may be null.
    double holdAll(const Where& where,
                   std::vector<Eigen::VectorXcf>& fields,
                   std::vector<device::DriveSignal>* drives = nullptr) const;

    /// The same for a sequence of one field or several. Returns the factor as played, between the
    /// root mean squares of the amplitudes: levels are coarser than factors. Throws as holdAll()
    /// does. \a capped may be null.
    double hold(const Where& where,
                haptics::FieldSequence& sequence,
                CappedDrives* capped = nullptr) const;
    /// Returns true if \a fields are nearer to the ear limit of \a where than to this cap.
    bool isForEars(const Where& where, const std::vector<Eigen::VectorXcf>& fields) const;
    /// Returns true if \a signals, which are played in turn as they are, keep to the ear limit of
    /// \a where, as hold() has it.
    bool keepsToEars(const Where& where, const std::vector<device::DriveSignal>& signals) const;
    /// The message for the user when all amplitudes were lowered by a factor < 1 that isn't 0.
    std::string message() const;

    /// Sets StopReason::SILENCED in \a report, of fields that were \a wanted and of which hold()
    /// (report.capFactor is 0) or the device's levels left nothing, and adds to its message why and
    /// what would sound. Returns what it added. Does nothing, and returns an empty text, if the
    /// report says already why nothing is played.
    std::string tellOfSilence(const Where& where,
                              const std::vector<Eigen::VectorXcf>& wanted,
                              const SilenceRemedy& remedy,
                              haptics::SolveReport& report) const;

    /// What \a fields would be with all that sounds in them at the device's lowest level, or with
    /// \a alone the first transducer that does.
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
    float _coarsest; ///< the most that rounding to levels changes an amplitude
};

} // namespace midair::bridge
