#include "engine-bridge/pipeline/ContactStage.h"

#include "engine-bridge/playing/StoreOf.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace midair::bridge
{

namespace
{

constexpr double kShow_s = 1.0 / 60.0; // interval of published fields of contacts
constexpr double kLeastPeriod_s = 2.5e-4;

} // namespace

ContactStage::ContactStage(PipelineContext& context, CappedOutput& output, HandStage& hands) :
    _context(context),
    _output(output),
    _hands(hands)
{
    setOptions();
}

void ContactStage::setOptions()
{
    const HologramOptions& options = _context.options;
    auto renderer =
        std::make_unique<ContactRenderer>(options.array, options.medium, options.contacts);
    if (_renderer) renderer->continueSensations(*_renderer);
    _renderer = std::move(renderer);
    _turn.forget();
}

void ContactStage::setReflectors()
{
    _renderer->setReflectors(_context.options.array);
    _turn.forget();
}

bool ContactStage::arrive(const SceneSnapshot*& snapshot)
{
    snapshot = &withContactShares(*snapshot);
    return true;
}

// Returns the snapshot itself if none of its objects is rendered by contacts.
const SceneSnapshot& ContactStage::withContactShares(const SceneSnapshot& snapshot)
{
    const bool had = std::exchange(_concerns, _renderer->concerns(snapshot.objects));
    if (!_concerns)
    {
        if (had) _renderer->clear();
        if (had) _turn.forget();
        _whole = {};
        return snapshot;
    }
    _shared = snapshot;
    _renderer->update(_shared.objects, _shared.hands, _shared.time_s, _shared.handsLate_s);
    std::vector<base::Message> problems;
    for (const std::string& problem : _renderer->problems())
        problems.emplace_back(base::MessageCode::HANDS_SOURCE, problem);
    _context.messages.sayNow({base::MessageCode::HANDS_SOURCE}, problems);
    return _shared;
}

bool ContactStage::isActive() const
{
    return _concerns && _renderer->isActive(_context.clock.now_s());
}

double ContactStage::period_s() const
{
    const double ofLine_Hz = _output.device().ability().fieldsPerSecond;
    const double wanted_Hz = _context.options.fieldRate;
    const double rate_Hz = ofLine_Hz > 0.0 ? std::min(wanted_Hz, ofLine_Hz) : wanted_Hz;
    return std::max(kLeastPeriod_s, 1.0 / rate_Hz);
}

bool ContactStage::compose(const haptics::FieldSequence& whole)
{
    if (_concerns) _whole = whole;
    return !_concerns;
}

bool ContactStage::takeOver(HologramResult& result)
{
    if (isActive())
    {
        _due_s = _context.clock.now_s(); // the solve may have taken longer than a field lasts
        if (_output.areEarsNew()) _turn.forget();
        playNext(&result);
        return true;
    }
    _isPlayed = false;
    _turn.forget();
    if (_concerns) result.touched = std::make_shared<const ContactScene>(_renderer->view());
    return false;
}

// Fields keep to the clock of their rate, however late each is; what is past is left out.
void ContactStage::scheduleNext(double now_s)
{
    const double next_s = _due_s + period_s();
    const double missed = std::floor((now_s - next_s) / period_s()) + 1.0;
    _due_s = next_s + std::max(missed, 0.0) * period_s();
}

// Plays the next field of contacts and stores its figures in the result, which may be null because
// they cost more than the field.
void ContactStage::playNext(HologramResult* result)
{
    const HologramOptions& options = _context.options;
    const double now_s = _context.clock.now_s();
    const double cap_Pa = options.contacts.field.absolute ? _output.maxPressure_Pa() : 0.0;
    if (playTurn(now_s, cap_Pa, result)) return;
    RenderedField rendered = _renderer->render(now_s, _whole, cap_Pa, 1.0 / period_s());
    std::vector<base::Message> failure;
    if (rendered.isFailed)
        failure.emplace_back(base::MessageCode::SOLVER_REFUSED, "contacts: " + rendered.error);
    _context.messages.sayNow({base::MessageCode::SOLVER_REFUSED, 0, "contacts"}, failure);
    haptics::FieldSequence sequence;
    sequence.report = rendered.report;
    sequence.report.transducers = options.array.size();
    sequence.report.capFactor = 1.0;
    sequence.modulation.fieldRate_Hz = options.fieldRate;
    haptics::ControlPoints points = _whole.points();
    points.targets *= _renderer->whole();
    haptics::append(points, rendered.foci);
    const int foci = rendered.foci.size();
    sequence.report.points = points.size();
    sequence.parts = {std::move(points)};
    sequence.fields = {std::move(rendered.q)};
    HologramResult unseen;
    _output.play(options.array, std::move(sequence), result ? *result : unseen, foci);
    _renderer->noteCap((result ? *result : unseen).sequence.report.capFactor);
    scheduleNext(now_s);
    _isPlayed = true;
    const std::vector<Eigen::VectorXcf> planned = _output.device().planned();
    const std::shared_ptr<const TimedField> last = _renderer->newest();
    _renderer->keep(now_s, planned.empty() ? Eigen::VectorXcf() : planned.front());
    ++_context.counters.contactFields;
    if (!result) return;
    _shown_s = now_s;
    _context.messages.sayNow({base::MessageCode::SENSATION_LIMITED},
                             _renderer->sensationProblems());
    result->touched = std::make_shared<const ContactScene>(_renderer->view());
    _output.measure(options.array, *result);
    result->fingertip.how = _renderer->playedAs();
    if (result->points.size() > 0) ratePlayed(*result);
    if (last)
        haptics::rateSwitch(last->q, 1.0 / period_s(), options.array.ringing_s, result->sequence);
}

// Returns false if the next field is to be played on its own. A turn is stored with a published
// result, which has its figures.
bool ContactStage::playTurn(double now_s, double cap_Pa, HologramResult* result)
{
    const double rate_Hz = 1.0 / period_s();
    const haptics::TurnStore store = storeOf(_output.device().ability(), rate_Hz);
    if (store.fields == 0) return false;
    const haptics::StoredTurn* turn = _turn.wanted(_renderer->steady(cap_Pa), store, now_s);
    if (!turn || (!_turn.isPlayed() && !result)) return false;
    _renderer->follow(now_s, cap_Pa, rate_Hz, *turn);
    if (_turn.isPlayed())
    {
        _output.attend(false); // sends it again after a loss or a mute
        if (result) continueTurn(*result);
    }
    else if (!storeTurn(*turn, now_s, *result))
        return false;
    scheduleNext(now_s);
    _isPlayed = true;
    if (!result) return true;
    _shown_s = now_s;
    _context.messages.sayNow({base::MessageCode::SENSATION_LIMITED},
                             _renderer->sensationProblems());
    result->touched = std::make_shared<const ContactScene>(_renderer->view());
    return true;
}

// Lowers the fields to the caps as one, and hands them to the device.
bool ContactStage::storeTurn(const haptics::StoredTurn& turn, double now_s, HologramResult& result)
{
    const haptics::TransducerArray& array = _context.options.array;
    haptics::FieldSequence sequence;
    for (RenderedField& field : _renderer->render(_turn.steady(), turn))
    {
        if (field.isFailed) return false; // as will the next field, which tells it
        sequence.report = field.report;
        sequence.parts.push_back(std::move(field.foci));
        sequence.fields.push_back(std::move(field.q));
    }
    sequence.report.transducers = array.size();
    sequence.report.capFactor = 1.0;
    sequence.modulation.fieldRate_Hz = turn.rate_Hz;
    const int foci = sequence.points().size();
    sequence.report.points = foci;
    _output.play(array, std::move(sequence), result, foci);
    _context.counters.contactFields += static_cast<std::uint64_t>(turn.fields);
    _renderer->keepTurn(now_s, turn.rate_Hz, _output.device().planned());
    _output.measure(array, result);
    result.fingertip.how =
        turn.turns > 0 ? haptics::PlayedAs::CIRCLING : haptics::PlayedAs::VIBRATING;
    if (result.points.size() > 0) ratePlayed(result);
    _turn.notePlayed();
    return true;
}

// The device plays the fields of the last result.
void ContactStage::continueTurn(HologramResult& result) const
{
    const HologramResult& last = *_context.last;
    result.array = last.array;
    result.points = last.points;
    result.foci = last.foci;
    result.sequence = last.sequence;
    result.achieved_Pa = last.achieved_Pa;
    result.fingertip = last.fingertip;
    result.maxPressure_Pa = last.maxPressure_Pa;
    result.handedOver_s = last.handedOver_s;
}

RestStep ContactStage::attend(bool /*isPlaying*/)
{
    if (!isActive() && !_isPlayed) return {};
    const double now_s = _context.clock.now_s();
    RestStep step;
    step.isAll = true;
    if (_output.device().isHoldOver()) return _isPlayed ? silence() : step; // frames stand still
    if (!isActive()) return playWhole();
    if (now_s < _due_s) return step;
    const bool isShown = now_s >= _shown_s + kShow_s;
    if (isShown) step.result = std::make_shared<HologramResult>(*_context.last);
    const bool isStored = _turn.isPlayed();
    playNext(step.result.get());
    step.isOtherField = isShown && !(isStored && _turn.isPlayed());
    return step;
}

RestStep ContactStage::silence()
{
    _renderer->endContacts();
    _turn.forget();
    _isPlayed = false;
    _output.device().silence(ArrayOutput::Silence::FAILED);
    RestStep step;
    step.result = std::make_shared<HologramResult>(*_context.last);
    step.result->touched = std::make_shared<const ContactScene>(_renderer->view());
    step.isAll = step.isOtherField = true;
    return step;
}

// The contacts have ended; plays the rest of the scene as without contacts.
RestStep ContactStage::playWhole()
{
    _isPlayed = false;
    _turn.forget();
    _renderer->pause();
    _context.messages.sayNow({base::MessageCode::SENSATION_LIMITED}, {});
    RestStep step;
    step.isAll = step.isOtherField = true;
    step.result = std::make_shared<HologramResult>(*_context.last);
    step.result->touched = std::make_shared<const ContactScene>(_renderer->view());
    const haptics::TransducerArray& array = _hands.shadowed(_whole.points());
    _output.play(array, _whole, *step.result);
    _output.measure(array, *step.result);
    _output.rateFromLast(*step.result);
    return step;
}

std::optional<double> ContactStage::rest_s(bool /*isPlaying*/) const
{
    constexpr double kWait_s = 0.01;
    if (isActive() && _output.device().isHoldOver()) return kWait_s;
    if (isActive()) return std::max(_due_s - _context.clock.now_s(), 0.0);
    if (_isPlayed) return 0.0; // they have just ended
    return std::nullopt;
}

void ContactStage::end()
{
    _renderer->clear();
    _turn.forget();
    _context.messages.sayNow({base::MessageCode::SENSATION_LIMITED}, {});
    _isPlayed = false;
}

} // namespace midair::bridge
