// How a HologramPipeline plays objects that are felt where hands touch them: a field at a time, on
// top of what is played of whole objects.
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <utility>

namespace midair::bridge
{

namespace
{

constexpr double kShow_s = 1.0 / 60.0; // of the fields of contacts one is published so often
constexpr double kLeastPeriod_s = 2.5e-4;

} // namespace

void HologramPipeline::makeContacts()
{
    _contacts =
        std::make_unique<ContactRenderer>(_options.array, _options.medium, _options.contacts);
}

// The snapshot itself if nothing in it is felt by contacts.
const SceneSnapshot& HologramPipeline::shared(const SceneSnapshot& snapshot)
{
    const bool had = std::exchange(_hasContacts, _contacts->concerns(snapshot.objects));
    if (!_hasContacts)
    {
        if (had) _contacts->clear();
        _whole = {};
        return snapshot;
    }
    _shared = snapshot;
    _contacts->update(_shared.objects, _shared.hands, _shared.time_s, _shared.handsLate_s);
    for (const std::string& problem : _contacts->problems())
        _messages.say({base::MessageCode::HANDS_SOURCE, problem});
    return _shared;
}

bool HologramPipeline::rendersContacts() const
{
    return _hasContacts && _contacts->isActive(base::steadySeconds());
}

double HologramPipeline::contactPeriod_s() const
{
    const double ofLine_Hz = _output->ability().fieldsPerSecond;
    const double rate_Hz =
        ofLine_Hz > 0.0 ? std::min(_options.fieldRate, ofLine_Hz) : _options.fieldRate;
    return std::max(kLeastPeriod_s, 1.0 / rate_Hz);
}

// Plays the next field of contacts, and puts its figures into the result, which may be null: they
// cost more than the field.
std::shared_ptr<const HologramResult>
HologramPipeline::playContacts(std::shared_ptr<HologramResult> result)
{
    const double now_s = base::steadySeconds();
    RenderedField rendered = _contacts->render(now_s, _whole);
    if (rendered.isFailed)
        _messages.say({base::MessageCode::SOLVER_REFUSED, "contacts: " + rendered.error});
    haptics::FieldSequence sequence;
    sequence.report = rendered.report;
    sequence.report.transducers = _options.array.size();
    sequence.report.capFactor = 1.0;
    sequence.modulation.fieldRate_Hz = _options.fieldRate;
    haptics::ControlPoints points = _whole.points();
    points.targets *= _contacts->view().whole;
    haptics::append(points, rendered.foci);
    sequence.report.points = points.size();
    sequence.parts = {std::move(points)};
    sequence.fields = {std::move(rendered.q)};
    HologramResult unseen;
    HologramResult& into = result ? *result : unseen;
    cap(_options.array, sequence, into);
    play(std::move(sequence), into);
    _contactField_s = now_s;
    _playsContacts = true;
    const std::vector<Eigen::VectorXcf> planned = _output->planned();
    const std::shared_ptr<const TimedField> last = _contacts->newest();
    _contacts->keep(now_s, planned.empty() ? Eigen::VectorXcf() : planned.front());
    ++_counters.contactFields;
    if (!result) return nullptr;
    _contactShown_s = now_s;
    _monitor->forget();
    result->touched = std::make_shared<const ContactScene>(_contacts->view());
    measure(_options.array, *result);
    if (result->points.size() > 0)
        haptics::rateLevel(result->points, result->achieved_Pa, result->sequence.report);
    if (last)
        haptics::rateSwitch(
            last->q, 1.0 / contactPeriod_s(), _options.array.ringing_s, result->sequence);
    finish(*result);
    return result;
}

std::shared_ptr<const HologramResult> HologramPipeline::attendContacts()
{
    const double now_s = base::steadySeconds();
    if (_output->isHoldOver()) // frames stand still
    {
        _contacts->clear();
        _playsContacts = false;
        silence();
        auto result = std::make_shared<HologramResult>(*_last);
        result->touched = std::make_shared<const ContactScene>(_contacts->view());
        finish(*result);
        return result;
    }
    if (!rendersContacts()) return playWhole();
    if (now_s < _contactField_s + contactPeriod_s()) return nullptr;
    const bool isShown = now_s >= _contactShown_s + kShow_s;
    return playContacts(isShown ? std::make_shared<HologramResult>(*_last) : nullptr);
}

// The contacts have ended; what is left of the scene is played as if there had been none.
std::shared_ptr<const HologramResult> HologramPipeline::playWhole()
{
    _playsContacts = false;
    _solved.resize(0);
    _contacts->pause();
    auto result = std::make_shared<HologramResult>(*_last);
    haptics::FieldSequence sequence = _whole;
    result->touched = std::make_shared<const ContactScene>(_contacts->view());
    const haptics::TransducerArray& array =
        _around.shadowed(sequence.points(), _options.array, _options.wavelength_m());
    cap(array, sequence, *result);
    play(std::move(sequence), *result);
    measure(array, *result);
    rateFromLast(*result);
    finish(*result);
    return result;
}

} // namespace midair::bridge
