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

/// Output of a pipeline: limits fields to the pressure cap at their points and to the level at
/// ears, plays them, and measures the result.
class CappedOutput
{
public:
    /// Opens the device, and sets the array's levels in \a context to the device's. Both must
    /// outlive this object. A failure to open is reported as a message.
    CappedOutput(PipelineContext& context, EarStage& ears);

    ArrayOutput& device() { return *_output; }
    const ArrayOutput& device() const { return *_output; }

    /// To be called when the device has been opened later: sets levels, line and caps by its
    /// ability.
    void useAbility();
    /// To be called when the options have changed.
    void setCaps();
    /// Returns true if the caps in \a options are so strict that the field being played or solved
    /// may exceed them. Any thread.
    bool isStricter(const HologramOptions& options) const;
    const haptics::LineRate& line() const { return _line; }
    /// Present pressure cap at the points; 0: none.
    double maxPressure_Pa() const { return _cap_Pa; }
    /// Returns true if the playing field keeps the ear limit at the ears' present places, and
    /// wasn't lowered for earlier ones.
    bool keepsToEars();
    /// To be called when reflectors have moved: lowers or silences what plays if it exceeds a cap
    /// with them.
    void keepCaps();
    /// Returns true if the ears' newest places need another field for the limit.
    bool areEarsNew() const { return !_ears.mayPlayOn(); }

    /// Lowers \a sequence to the caps, with the transducers of \a solvedFor and all reflectors, and
    /// plays it. Its last \a foci points are contacts, in Pa.
    void play(const haptics::TransducerArray& solvedFor,
              haptics::FieldSequence sequence,
              HologramResult& result,
              int foci = 0);
    /// Silences the device, because the wanted field can't be played.
    void silence();
    /// Stores the playing fields and their pressures at the points in \a result.
    void measure(const haptics::TransducerArray& solvedFor, HologramResult& result);
    /// Rates the step from the context's last result to \a result.
    void rateFromLast(HologramResult& result) const;
    /// Checks the device: resends a field that it has lost. Returns true if the last result is
    /// outdated; with \a areOptionsNew the next result will tell more.
    bool attend(bool areOptionsNew);
    /// Copies the playing fields and their figures to \a result: they continue for \a points of \a
    /// sequence, which the solver found unmoved.
    void playOn(const haptics::FieldSequence& sequence,
                haptics::ControlPoints points,
                const haptics::TransducerArray& array,
                HologramResult& result);
    /// Returns the array's state while \a result is played; unrequested silence counts as SILENT.
    ArrayState stateOf(const HologramResult& result);

private:
    /// Present pressure cap.
    struct PressureLimit
    {
        std::unique_ptr<PressureCap> cap; ///< of the highest pressure if there is no cap
        bool isSet = false;               ///< there is a cap
        std::string name;                 ///< the setting that it comes from
    };

    /// The object last reported as asking for the most: it stays while it asks for too much, so
    /// that texts don't change from field to field.
    struct Asking
    {
        int object = -1; ///< of the snapshot; -1: none
        bool isContact = false;
        double pressure_Pa = 0.0;
    };

    void warnIfNoTransducerSounds();
    void setPressureCap();
    const haptics::TransducerArray& heard(const haptics::TransducerArray& array);
    PressureCap::Where
    where(const haptics::TransducerArray& array, const Eigen::Matrix3Xd& points, bool modulated);
    void cap(const haptics::TransducerArray& array,
             haptics::FieldSequence& sequence,
             HologramResult& result,
             int foci);
    std::string
    asking(const haptics::ControlPoints& points, int foci, double over_Pa, bool isOfContacts);
    void tellOfCap(bool isHeld, const haptics::ControlPoints& points, int foci);
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
    std::atomic<double> _cap_Pa{0.0}; // copy of _pressure's, for any thread; 0: none
    std::vector<base::Message> _told; // effects of caps and device on the playing field
    bool _isForEars = false;          // the ear limit was stricter for the last field
    Asking _asking;
    haptics::TransducerArray _heard; // of heard()
    CappedDrives _proven; // result of the last cap(), for send(); without drives: not capped
};

} // namespace midair::bridge
