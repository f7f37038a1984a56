#pragma once

#include "engine-bridge/pipeline/PipelineStage.h"
#include "engine-bridge/playing/ArrayOutput.h"
#include "engine-bridge/playing/PressureCap.h"
#include "haptics/sequence/Modulator.h"

#include <atomic>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// The way out of a pipeline: keeps fields to the caps of the pressure at their points and of the
/// level at ears, plays them, and measures what the array makes of them.
class CappedOutput
{
public:
    /// Opens the device, and sets the array's levels in \a context to those that it has. Both must
    /// outlive it. A device that can't be opened is a message.
    CappedOutput(PipelineContext& context, EarStage& ears);

    ArrayOutput& device() { return *_output; }
    const ArrayOutput& device() const { return *_output; }

    /// To be called when the device has been opened later: sets levels, line and caps to what it
    /// can do.
    void useAbility();
    /// To be called when the options have changed.
    void setCaps();
    /// Returns true if the caps in \a options are so strict that what is played, or being solved,
    /// may exceed them. Any thread.
    bool isStricter(const HologramOptions& options) const;
    const haptics::LineRate& line() const { return _line; }
    /// Returns true if what is played keeps to the ear limit where the ears are now, and wasn't
    /// held down for where they were.
    bool keepsToEars();

    /// Lowers \a sequence to the caps, which hold with the transducers of \a array, and plays it.
    void play(const haptics::TransducerArray& array,
              haptics::FieldSequence sequence,
              HologramResult& result);
    /// Silences the device, as what was asked for can't be played.
    void silence();
    /// Puts what is played, and what it gives at the points, into \a result.
    void measure(const haptics::TransducerArray& array, HologramResult& result);
    /// Rates the step from the context's last result to \a result.
    void rateFromLast(HologramResult& result) const;
    /// Looks after the device: resends a field that it has lost. Returns true if the last result
    /// doesn't tell what has come of it; with \a areOptionsNew the next one will tell more.
    bool attend(bool areOptionsNew);
    /// Takes over into \a result what is played, and its figures, since it goes on for \a points of
    /// \a sequence, which the solver found as they were.
    void playOn(const haptics::FieldSequence& sequence,
                haptics::ControlPoints points,
                const haptics::TransducerArray& array,
                HologramResult& result);
    /// What the array does while \a result is played; nothing that sounds counts as silence.
    ArrayState stateOf(const HologramResult& result);

private:
    /// The cap of the pressure that holds now.
    struct PressureLimit
    {
        std::unique_ptr<PressureCap> cap; ///< of the highest pressure there is, if there is no cap
        bool isSet = false;               ///< there is a cap
        std::string name;                 ///< the setting that it comes from
    };

    void warnIfNoTransducerSounds();
    void setPressureCap();
    PressureCap::Where
    where(const haptics::TransducerArray& array, const Eigen::Matrix3Xd& points, bool modulated);
    void cap(const haptics::TransducerArray& array,
             haptics::FieldSequence& sequence,
             HologramResult& result);
    void tellOfSilence(const PressureCap::Where& where,
                       const std::vector<Eigen::VectorXcf>& wanted,
                       haptics::SolveReport& report);
    void send(haptics::FieldSequence sequence, HologramResult& result);
    void tell();
    bool isMeasured() const;

    PipelineContext& _context;
    EarStage& _ears;
    bool _isDead = false; // no transducer of the array sounds
    std::unique_ptr<ArrayOutput> _output;
    haptics::LineRate _line;
    PressureLimit _pressure;
    std::atomic<double> _cap_Pa{0.0}; // that of _pressure, for any thread; 0: none
    std::vector<base::Message> _told; // of what is played: how caps and device change it
    bool _isForEars = false;          // the last field was held down to the ear limit
    CappedDrives _proven; // by the last cap(), which send() sends; without drives: not capped
};

} // namespace midair::bridge
