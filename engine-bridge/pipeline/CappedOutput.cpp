#include "engine-bridge/pipeline/CappedOutput.h"

#include "device/limits/GuardedDevice.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

/// The largest amplitude that \a output plays: by its cap, and by its device's.
double mostAmplitude(const ArrayOutput& output)
{
    return std::min(output.amplitudeCap(), output.ability().maxAmplitude);
}

} // namespace

PipelineContext::PipelineContext(HologramOptions given) :
    options(std::move(given)),
    clock(*options.clock)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    fillIn(options);
    for (const base::Message& note : options.notes)
        messages.say(note);
    keepToLimits(options, messages);
    ownReflectors = options.array.reflectors;
    reflectors = reflectorsBeside(options.array, {});
    copyArray();
}

bool PipelineContext::follow(const SceneSnapshot& snapshot)
{
    const double tolerance_m = 0.5 * options.motionTolerance * options.wavelength_m();
    if (areUnmoved(snapshot.reflectors, faces, tolerance_m) &&
        areUnmoved(snapshot.bodies, bodies, tolerance_m))
        return false;
    faces = snapshot.reflectors;
    bodies = snapshot.bodies;
    options.array.reflectors = ownReflectors;
    reflectors = reflectorsBeside(options.array, faces);
    copyArray();
    return true;
}

void PipelineContext::copyArray()
{
    options.array.reflectors = reflectors.all;
    array = std::make_shared<const haptics::TransducerArray>(options.array);
    options.array.reflectors = ownReflectors;
    bare =
        faces.empty() ? nullptr : std::make_shared<const haptics::TransducerArray>(options.array);
    options.array.reflectors = reflectors.corrected;
}

std::shared_ptr<const haptics::TransducerArray>
PipelineContext::kept(const haptics::TransducerArray& heard) const
{
    return &heard == &options.array || &heard == array.get()
               ? array
               : std::make_shared<const haptics::TransducerArray>(heard);
}

// The device is opened with a copy of the options, because a second try runs in another thread.
CappedOutput::CappedOutput(PipelineContext& context, EarStage& ears) :
    _context(context),
    _ears(ears)
{
    warnIfNoTransducerSounds();
    const HologramOptions& options = _context.options;
    const auto open = [factory = options.deviceFactory,
                       uri = options.deviceUri,
                       layout = device::DeviceLayout{
                           options.array.size(), options.array.board, options.array.dead}] {
        return factory(uri, layout);
    };
    _output =
        std::make_unique<ArrayOutput>(open, _context.messages, options.reopen_s, _context.clock);
    _output->setAmplitudeCap(options.maxAmplitude);
    useAbility();
}

// The amplitude cap stays: it may have been lowered since the options were given.
void CappedOutput::useAbility()
{
    const device::DriveAbility ability = _output->ability();
    _line = haptics::LineRate(ability.fieldsPerSecond,
                              ability.amplitudes.size() == 2,
                              ability.sequenceFields,
                              ability.sequenceClock_Hz);
    keepToLevels(_context.options, ability);
    setPressureCap();
    _context.copyArray();
}

void CappedOutput::warnIfNoTransducerSounds()
{
    const haptics::TransducerArray& array = _context.options.array;
    _isDead = array.gain.size() > 0 && array.gain.isZero(0.0);
    if (_isDead)
        _context.messages.say(
            {base::MessageCode::ARRAY_DEAD,
             fmt::format("all {} transducers of the array are dead or have the gain 0; "
                         "it is silent",
                         array.size())});
}

void CappedOutput::setCaps()
{
    _output->setAmplitudeCap(_context.options.maxAmplitude);
    setPressureCap();
}

// Uses the stricter of the caps of options and device.
void CappedOutput::setPressureCap()
{
    const device::DriveAbility ability = _output->ability();
    const double cap_Pa = device::stricterCap(_context.options.maxPressure, ability.maxPressure_Pa);
    _pressure.isSet = cap_Pa > 0.0;
    _cap_Pa = cap_Pa;
    _pressure.name =
        cap_Pa == _context.options.maxPressure ? "MaxPressure" : "max-pressure of the device";
    const auto wouldPlay = [this](const device::DriveSignal& signal)
    { return _output->wouldPlay(signal); };
    _pressure.cap = std::make_unique<PressureCap>(
        _pressure.isSet ? cap_Pa : base::kMostPressure_Pa, wouldPlay, ability);
}

// The device applies a lower amplitude by itself, but a pressure cap needs the fields being capped
// to be rounded to other levels.
bool CappedOutput::isStricter(const HologramOptions& options) const
{
    const double now_Pa = _cap_Pa;
    if (!(options.maxPressure >= 0.0) || !(options.earLimit >= 0.0)) return true;
    const double ears_dB = _ears.limit_dB();
    if (options.earLimit > 0.0 && !(ears_dB > 0.0 && options.earLimit >= ears_dB)) return true;
    // Lower amplitudes are rounded to other levels, which need a new factor.
    if (ears_dB > 0.0 && !(options.maxAmplitude >= _output->amplitudeCap())) return true;
    if (options.maxPressure > 0.0 && !(now_Pa > 0.0 && options.maxPressure >= now_Pa)) return true;
    return now_Pa > 0.0 && !(options.maxAmplitude >= _output->amplitudeCap());
}

// What sounds for a field solved for \a array: all reflectors, also those that aren't corrected.
const haptics::TransducerArray& CappedOutput::heard(const haptics::TransducerArray& array)
{
    const std::vector<haptics::Reflector>& all = _context.array->reflectors;
    if (array.reflectors == all) return array;
    if (&array == &_context.options.array) return *_context.array;
    _heard = array;
    _heard.reflectors = all;
    return _heard;
}

// A shadowing hand or a reflector may be gone before the next field, so the cap must hold without
// it too.
PressureCap::Where CappedOutput::where(const haptics::TransducerArray& array,
                                       const Eigen::Matrix3Xd& points,
                                       bool modulated)
{
    static const Eigen::Matrix3Xd kNowhere(3, 0);
    std::vector<const haptics::TransducerArray*> arrays{&array};
    if (&array != &_context.options.array && &array != _context.array.get())
        arrays.push_back(_context.array.get());
    if (_context.bare) arrays.push_back(_context.bare.get());
    return {_pressure.isSet ? points : kNowhere,
            std::move(arrays),
            _context.options.medium,
            modulated,
            _context.options.solverOptions.threads,
            _context.options.solverOptions.stop,
            _ears.bound()};
}

// Checks the playing field, whose bytes are unchanged.
bool CappedOutput::keepsToEars()
{
    static const Eigen::Matrix3Xd kNoPoints(3, 0);
    if (_isForEars || !_context.last) return false;
    const bool isModulated = _context.last->sequence.modulation.amplitudeRate_Hz > 0.0;
    return _pressure.cap->keepsToEars(where(*_context.array, kNoPoints, isModulated),
                                      _output->drives());
}

// What plays was proven for reflectors that are elsewhere now. Until the next field it is lowered
// as they require; fields of contacts, of which the next one comes at once, are silenced.
void CappedOutput::keepCaps()
{
    const HologramResult* last = _context.last.get();
    if (!(_pressure.isSet || _ears.limit_dB() > 0.0) || !last || !_output->isPlaying() ||
        last->sequence.isEmpty())
        return;
    haptics::FieldSequence playing = last->sequence;
    playing.fields = _output->planned();
    playing.achieved_Pa.resize(0);
    playing.outside = nullptr; // it was that of the former places
    const bool isModulated = playing.modulation.amplitudeRate_Hz > 0.0;
    std::vector<Eigen::VectorXcf> fields = playing.fields;
    if (fields.empty()) return;
    const Eigen::Matrix3Xd points = playing.points().positions;
    const double factor =
        _pressure.cap->holdAll(where(*_context.array, points, isModulated), fields);
    if (factor >= 1.0) return;
    HologramResult unseen;
    if (last->foci > 0 || !(factor > 0.0))
        silence();
    else
        play(*_context.array, std::move(playing), unseen);
}

// The object that asks for the most at \a points and for more than \a over_Pa: "Ring wants 11 kPa,
// by its contactForce". Empty if none does, or if the targets are ratios. \a isOfContacts: ignores
// whole objects.
std::string CappedOutput::asking(const haptics::ControlPoints& points,
                                 int foci,
                                 double over_Pa,
                                 bool isOfContacts)
{
    constexpr double kSameAs = 1.1;
    Asking most;
    double ofLast_Pa = 0.0;
    for (int l = 0; l < points.size() && !points.object.empty(); ++l)
    {
        const bool isContact = l >= points.size() - foci;
        const int object = points.object[static_cast<std::size_t>(l)];
        const double wanted_Pa = points.targets[l];
        if (!(isContact || (points.absolute && !isOfContacts)) || !(wanted_Pa > over_Pa) ||
            object < 0 || object >= static_cast<int>(_context.paths.size()))
            continue;
        if (wanted_Pa > most.pressure_Pa) most = {object, isContact, wanted_Pa};
        if (object == _asking.object && isContact == _asking.isContact)
            ofLast_Pa = std::max(ofLast_Pa, wanted_Pa);
    }
    if (!(ofLast_Pa > 0.0))
        _asking = most;
    else if (ofLast_Pa > kSameAs * _asking.pressure_Pa)
        _asking.pressure_Pa = ofLast_Pa;
    if (_asking.object < 0) return {};
    const double asked_Pa = _asking.pressure_Pa;
    const bool isTouch =
        _asking.isContact && !_context.areSensations[static_cast<std::size_t>(_asking.object)];
    const bool isLarge = asked_Pa >= 1000.0;
    return fmt::format("{} wants {:.3g} {}, by its {}",
                       _context.paths[static_cast<std::size_t>(_asking.object)],
                       isLarge ? asked_Pa / 1000.0 : asked_Pa,
                       isLarge ? "kPa" : "Pa",
                       isTouch ? "contactForce" : "pressure");
}

// Reports the binding cap, and the object that asks for too much. A contact that does is solved for
// the cap, so that the field as a whole need not be lowered.
void CappedOutput::tellOfCap(bool isHeld, const haptics::ControlPoints& points, int foci)
{
    using base::MessageCode;
    const double cap_Pa = maxPressure_Pa();
    std::string who;
    if (isHeld || (foci > 0 && cap_Pa > 0.0))
        who = asking(points, foci, _isForEars ? 0.0 : cap_Pa, !isHeld);
    if (who.empty()) _asking = {};
    if (!isHeld && who.empty()) return;
    const std::string after = who.empty() ? who : ": " + who;
    if (_isForEars)
        _told.emplace_back(MessageCode::CAP_EARS,
                           fmt::format("the field is held down to the ear limit of {:g} dB{}",
                                       _ears.limit_dB(),
                                       after));
    else if (_asking.isContact)
        _told.emplace_back(
            MessageCode::CAP_PRESSURE,
            fmt::format("{}, and is held down to {:g} Pa ({})", who, cap_Pa, _pressure.name));
    else
        _told.emplace_back(
            MessageCode::CAP_PRESSURE,
            fmt::format("{}, by {}{}", _pressure.cap->message(), _pressure.name, after));
}

void CappedOutput::cap(const haptics::TransducerArray& array,
                       haptics::FieldSequence& sequence,
                       HologramResult& result,
                       int foci)
{
    _proven = {};
    _isForEars = false;
    if (sequence.isHeld() && sequence.achieved_Pa.size() > 0)
        _proven.held = {1.0, sequence.fields.front(), sequence.achieved_Pa};
    if (!_pressure.isSet && !(_ears.limit_dB() > 0.0)) return;
    if (_pressure.isSet) result.maxPressure_Pa = _pressure.cap->max_Pa();
    if (sequence.isEmpty()) return;
    const haptics::ControlPoints points = sequence.points();
    const PressureCap::Where place =
        where(array, points.positions, sequence.modulation.amplitudeRate_Hz > 0.0);
    const std::vector<Eigen::VectorXcf> wanted = sequence.fields;
    sequence.report.capFactor = sequence.most * _pressure.cap->hold(place, sequence, &_proven);
    // For parts that may sound alone the cap counts each separately; what is outside it doesn't
    // know.
    if (!_output->ability().part.empty() || sequence.outside) _proven.held = {};
    if (sequence.report.capFactor >= 1.0) return tellOfCap(false, points, foci);
    ++_context.counters.capped;
    // For silence it is unknown which of the two limits it keeps.
    _isForEars = _ears.limit_dB() > 0.0 && (sequence.report.capFactor <= 0.0 || !_pressure.isSet ||
                                            _pressure.cap->isForEars(place, sequence.fields));
    if (sequence.report.capFactor <= 0.0)
        tellOfSilence(place, wanted, sequence.report);
    else
        tellOfCap(true, points, foci);
}

// The pressures in the message are a snapshot: it is reported once, and each report has new ones.
void CappedOutput::tellOfSilence(const PressureCap::Where& where,
                                 const std::vector<Eigen::VectorXcf>& wanted,
                                 haptics::SolveReport& report)
{
    const auto forget = [this]
    {
        const auto isOld = [](const base::Message& message)
        { return message.code == base::MessageCode::FIELD_SILENCED; };
        _told.erase(std::remove_if(_told.begin(), _told.end(), isOld), _told.end());
    };
    if (_isDead || _context.options.isSilencedElsewhere) return forget(); // reported already
    const double most = _output->amplitudeCap();
    // It was lowered for options that are about to come, and that name the reason.
    if (most < _context.options.maxAmplitude) return;
    const std::string amplitude = most <= 0.0  ? "MaxAmplitude, which is 0"
                                  : most < 1.0 ? fmt::format("MaxAmplitude, which is {:g}", most)
                                               : "max-amplitude of the device";
    const std::string told = _pressure.cap->tellOfSilence(
        where, wanted, {_pressure.name, "Pressure or Loudness", amplitude}, report);
    if (told.empty()) return;
    forget();
    _told.emplace_back(base::MessageCode::FIELD_SILENCED, told);
}

void CappedOutput::play(const haptics::TransducerArray& solvedFor,
                        haptics::FieldSequence sequence,
                        HologramResult& result,
                        int foci)
{
    const haptics::TransducerArray& array = heard(solvedFor);
    if (&array != &solvedFor) sequence.achieved_Pa.resize(0);
    // The device lowers each field separately, which changes the ratios of several fields, and
    // clips the peaks of a modulation.
    const double most = mostAmplitude(*_output);
    if (sequence.changes() && most > 0.0 && haptics::keepAmplitudes(most, sequence.fields))
        sequence.achieved_Pa.resize(0);
    if (haptics::keepAmplitudes(sequence.most, sequence.fields)) sequence.achieved_Pa.resize(0);
    _told.clear();
    result.foci = foci;
    cap(array, sequence, result, foci);
    send(std::move(sequence), result);
    tell();
}

// Reports what caps and device do to the playing field, and nothing about earlier ones.
void CappedOutput::tell()
{
    _context.messages.sayNow({base::MessageCode::CAP_PRESSURE}, _told);
}

void CappedOutput::silence()
{
    _output->silence(ArrayOutput::Silence::FAILED);
    _told.clear();
    tell();
}

void CappedOutput::send(haptics::FieldSequence sequence, HologramResult& result)
{
    result.points = sequence.points();
    if (sequence.isEmpty() || sequence.report.capFactor <= 0.0)
    {
        const bool failed = sequence.report.stop == haptics::StopReason::REFUSED;
        _output->silence(failed ? ArrayOutput::Silence::FAILED : ArrayOutput::Silence::WANTED);
        sequence.fields = {Eigen::VectorXcf::Zero(_context.options.array.size())};
    }
    else
    {
        const haptics::TransducerArray& array = _context.options.array;
        std::vector<device::DriveSignal> drives = std::move(_proven.drives);
        if (drives.empty()) drives = drivesOf(sequence.fields, array.size(), array.dead);
        _output->play(std::move(drives), sequence.modulation, _context.options.solverOptions.stop);
        const bool isStored = _line.isSlowerThan(sequence.modulation.fieldRate_Hz);
        if (sequence.fields.size() > 1 && _line.isSlowerThan(_context.options.fieldRate) &&
            !isStored)
            _told.emplace_back(base::MessageCode::DEVICE_SLOW,
                               _line.message(sequence.modulation, _context.options.modulation));
    }
    result.handedOver_s = _context.clock.now_s();
    result.sequence = std::move(sequence);
}

void CappedOutput::measure(const haptics::TransducerArray& solvedFor, HologramResult& result)
{
    const haptics::TransducerArray& array = heard(solvedFor);
    result.array = _context.kept(array);
    const std::vector<Eigen::VectorXcf> wanted = result.sequence.fields;
    if (measurePlayed(*_output,
                      array,
                      _context.options.medium,
                      _context.options.solverOptions,
                      _proven.held,
                      result,
                      &array == &solvedFor))
        return;
    const bool modulated = result.sequence.modulation.amplitudeRate_Hz > 0.0;
    tellOfSilence(where(array, result.points.positions, modulated), wanted, result.sequence.report);
    tell();
}

// A solver knows neither the cap nor the fields of other solvers, such as those of a cycle's other
// sets: its step and level jump are those between its own fields.
void CappedOutput::rateFromLast(HologramResult& result) const
{
    if (!_context.last) return;
    haptics::SolveReport& report = result.sequence.report;
    const double before_Pa = _context.last->report().level_Pa;
    const bool isJump = report.level_Pa > 0.0 && before_Pa > 0.0;
    report.levelJump =
        isJump ? std::max(report.level_Pa / before_Pa, before_Pa / report.level_Pa) : 0.0;
    const double rate_Hz = _context.options.solverOptions.updateRate_Hz;
    haptics::rateSwitch(
        _context.last->played(), rate_Hz, _context.options.array.ringing_s, result.sequence);
    const bool isLowered = report.capFactor < 1.0 || _context.last->report().capFactor < 1.0 ||
                           mostAmplitude(*_output) < 1.0;
    if (isLowered && result.sequence.isHeld() && _context.last->sequence.isHeld())
        haptics::rateStep(_context.last->played(), rate_Hz, result.sequence);
}

// Figures of a field at rest were taken when it was sent; a ramp or thermal budget continues.
bool CappedOutput::isMeasured() const
{
    if (_context.last->sequence.fields.size() != 1 || !_output->ability().fades) return true;
    const std::vector<Eigen::VectorXcf> now = _output->played();
    return now.size() == 1 && now.front() == _context.last->played();
}

bool CappedOutput::attend(bool areOptionsNew)
{
    const auto attention = _output->attend(_context.options.solverOptions.stop);
    const bool isTold = _output->tellOfDriver();
    // After a change of options the next process() reports more than the fate of the last field.
    if (attention == ArrayOutput::Attention::NOTHING && !isTold && isMeasured() &&
        (areOptionsNew || stateOf(*_context.last) == _context.last->state))
        return false;
    if (attention == ArrayOutput::Attention::RESENT) ++_context.counters.resent;
    return true;
}

// Takes over the playing field and its figures. While snapshots keep coming attend() isn't called,
// so the device is checked here.
void CappedOutput::playOn(const haptics::FieldSequence& sequence,
                          haptics::ControlPoints points,
                          const haptics::TransducerArray& array,
                          HologramResult& result)
{
    // The places for which they were solved; otherwise many small steps would go unnoticed.
    points.positions = _context.last->points.positions;
    result.array = _context.last->array;
    result.maxPressure_Pa = _context.last->maxPressure_Pa;
    result.achieved_Pa = _context.last->achieved_Pa;
    result.fingertip = _context.last->fingertip;
    result.handedOver_s = _context.last->handedOver_s;
    result.sequence = _context.last->sequence;
    result.sequence.parts = {points};
    result.points = std::move(points);
    haptics::SolveReport& report = result.sequence.report;
    if (report.capFactor < 1.0) ++_context.counters.capped;
    report.stop = sequence.report.stop;
    report.rowsBuilt = report.iterations = 0;
    report.matrix_ms = report.solve_ms = 0.0;
    report.meanPhaseStep_rad = report.driveChange = report.audibleChange = 0.0;
    report.levelJump = sequence.report.levelJump;
    report.ringingShare = sequence.report.ringingShare;
    const auto attention = _output->attend(_context.options.solverOptions.stop);
    if (attention == ArrayOutput::Attention::RESENT) ++_context.counters.resent;
    if (attention != ArrayOutput::Attention::NOTHING || !isMeasured()) measure(array, result);
}

ArrayState CappedOutput::stateOf(const HologramResult& result)
{
    const ArrayState state = _output->state();
    const bool isNothing =
        state == ArrayState::PLAYING && (_isDead || result.isSilenced() || !_output->sounds());
    _output->judge(isNothing ? ArrayState::SILENT : state);
    return isNothing ? ArrayState::SILENT : state;
}

} // namespace midair::bridge
