#include "engine-bridge/pipeline/ContactStage.h"

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
        playNext(&result);
        return true;
    }
    _isPlayed = false;
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
    result->fingertip.how = haptics::PlayedAs::CIRCLING;
    if (result->points.size() > 0) ratePlayed(*result);
    if (last)
        haptics::rateSwitch(last->q, 1.0 / period_s(), options.array.ringing_s, result->sequence);
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
    playNext(step.result.get());
    step.isOtherField = isShown;
    return step;
}

RestStep ContactStage::silence()
{
    _renderer->endContacts();
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
    _context.messages.sayNow({base::MessageCode::SENSATION_LIMITED}, {});
    _isPlayed = false;
}

} // namespace midair::bridge
