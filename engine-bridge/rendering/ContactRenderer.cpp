#include "engine-bridge/rendering/ContactRenderer.h"

#include "haptics/base/InputError.h"
#include "haptics/sequence/Modulator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

constexpr double kLeastDepth_m = 1e-6;  ///< smaller depths give no pressure
constexpr double kLongestStep_s = 0.02; ///< longest time step of one field
/// An object that fades beside others changes its share in this many steps, each of them a solve.
constexpr double kShareSteps = 4.0;

} // namespace

bool ContactRendererOptions::isValid(std::string* error) const
{
    return tracker.isValid(error) && field.isValid(error) && shares.isValid(error);
}

ContactRenderer::ContactRenderer(const haptics::TransducerArray& array,
                                 const haptics::Medium& medium,
                                 const ContactRendererOptions& options) :
    _options(options),
    _tracker(options.tracker, medium),
    _field(array, medium, options.field),
    _shares(options.shares),
    _sensations(array, medium)
{
}

void ContactRenderer::update(std::vector<HapticObject>& objects,
                             const HandFrame& hands,
                             double time_s,
                             double rest_s)
{
    // A frame's time may go back a little, by the age of its data.
    const double now_s = _isUpdated ? std::max(time_s, _updated_s) : time_s;
    std::vector<HapticObject> touched;
    _objects.clear();
    for (std::size_t i = 0; i < objects.size(); ++i)
    {
        const HapticObject& object = objects[i];
        if (_shares.renderOf(object) == Render::OBJECT) continue;
        if (object.mesh && object.mesh->triangles.cols() > 0) touched.push_back(object);
        _objects.emplace(object.touchId(),
                         Known{static_cast<int>(i),
                               object.properties.priority,
                               object.properties.sensation.isMeant});
    }
    _tracker.update(touched, hands, now_s);
    _sensations.update(objects, hands, _tracker.contacts(), now_s);
    _shares.update(objects, _tracker.contacts(), hands, now_s, std::max(rest_s, 0.0));
    _updated_s = now_s;
    _isUpdated = true;
    if (!_wasActive) _rendered_s = now_s;
    // The largest share of all scales the field; these are the others relative to it.
    const double most = _shares.mostWhole();
    _levels.wholePriority = kNone;
    for (HapticObject& object : objects)
    {
        const double share = _shares.whole(object.touchId());
        if (share > 0.0)
            _levels.wholePriority = std::max(_levels.wholePriority, object.properties.priority);
        object.share = most > 0.0 ? std::ceil(kShareSteps * share / most) / kShareSteps : 0.0;
    }
}

void ContactRenderer::clear()
{
    endContacts();
    _shares.clear();
    _sensations.clear();
    _isUpdated = false;
}

void ContactRenderer::endContacts()
{
    _tracker.end();
    pause();
}

void ContactRenderer::pause()
{
    _foci.clear();
    _recent.clear();
    _wasActive = false;
    _levels.others = {};
    _levels.sensations = {};
    _sensations.pause();
}

bool ContactRenderer::isActive(double now_s) const
{
    if (!_isUpdated) return false;
    if (_shares.isFading() || _sensations.isActive() || _levels.others.isFading()) return true;
    if (now_s - _updated_s > kStale_s) return false;
    const std::vector<Contact>& contacts = _tracker.contacts();
    return std::any_of(
        contacts.begin(), contacts.end(), [this](const Contact& one) { return presses(one); });
}

bool ContactRenderer::presses(const Contact& contact) const
{
    const auto known = _objects.find(contact.path.patch().object);
    if (known != _objects.end() && known->second.isSensation) return false;
    return contact.wanted_m > 0.0 || contact.depth_m > kLeastDepth_m;
}

// The field of whole objects is one, so it has the priority of its most important object; it makes
// nothing else give way. What hasn't faded yet has its full level before the highest changes.
void ContactRenderer::settlePrecedence(double dt_s)
{
    if (_levels.wholePriority > kNone) _levels.others.level(_levels.wholePriority);
    const int ofSensations = _sensations.highestPriority(kNone);
    int highest = ofSensations;
    const bool isFresh = _rendered_s - _updated_s <= kStale_s;
    for (const Contact& contact : _tracker.contacts())
    {
        const auto known = _objects.find(contact.path.patch().object);
        if (known == _objects.end() || !isFresh || !presses(contact)) continue;
        _levels.others.level(known->second.priority);
        highest = std::max(highest, known->second.priority);
    }
    _levels.others.advance(dt_s, ofSensations);
    _levels.sensations.advance(dt_s, highest);
    const double level =
        _levels.wholePriority > kNone ? _levels.others.level(_levels.wholePriority) : 1.0;
    _levels.whole = _shares.mostWhole() * level;
}

bool ContactRenderer::isOfSensation(const ContactFocus& focus) const
{
    const auto known = _objects.find(focus.object);
    return known != _objects.end() && known->second.isSensation;
}

bool ContactRenderer::areOfSensations() const
{
    return std::all_of(_foci.begin(),
                       _foci.end(),
                       [this](const ContactFocus& focus) { return isOfSensation(focus); });
}

haptics::PlayedAs ContactRenderer::playedAs() const
{
    return areOfSensations() ? _sensations.playedAs() : haptics::PlayedAs::CIRCLING;
}

// A factor that others bring about is theirs, and comes again with each field.
void ContactRenderer::noteCap(double factor)
{
    if (!isWholePlayed() && areOfSensations() && !_foci.empty())
        _sensations.noteCap(factor, _step_s);
}

void ContactRenderer::addContacts(double now_s)
{
    if (now_s - _updated_s > kStale_s) return;
    for (ContactFocus focus : _tracker.foci())
    {
        const auto known = _objects.find(focus.object);
        if (known == _objects.end() || known->second.isSensation) continue;
        focus.pressure_Pa *=
            _shares.contacts(focus.object) * _levels.others.level(known->second.priority);
        if (focus.pressure_Pa > 0.0) _foci.push_back(focus);
    }
}

haptics::ControlPoints
ContactRenderer::pointsWithObjects(const std::vector<ContactFocus>& foci) const
{
    haptics::ControlPoints points = pointsOf(foci);
    for (const ContactFocus& focus : foci)
    {
        const auto found = _objects.find(focus.object);
        points.object.push_back(found == _objects.end() ? 0 : found->second.index);
    }
    return points;
}

void ContactRenderer::addWhole(double now_s,
                               const haptics::FieldSequence& whole,
                               Eigen::VectorXcf& q) const
{
    if (whole.isEmpty() || !(_levels.whole > 0.0)) return;
    const haptics::Modulator modulator(whole.modulation);
    const auto step = modulator.at(now_s, static_cast<int>(whole.fields.size()));
    const Eigen::VectorXcf& field = whole.fields[static_cast<std::size_t>(step.field)];
    if (field.size() == q.size()) q += static_cast<float>(_levels.whole * step.amplitude) * field;
    const float most = q.cwiseAbs().maxCoeff();
    if (most > 1.0f) q /= most;
}

void ContactRenderer::advance(double now_s,
                              double most_Pa,
                              double rate_Hz,
                              const haptics::StoredTurn* turn)
{
    _step_s = std::clamp(now_s - _rendered_s, 0.0, kLongestStep_s);
    _rendered_s = now_s;
    _wasActive = true;
    _tracker.advance(_step_s);
    _shares.advance(_step_s);
    settlePrecedence(_step_s);
    _foci.clear();
    addContacts(now_s);
    _sensations.render(now_s, _step_s, rate_Hz, turn, most_Pa, _levels.sensations, _foci);
}

RenderedField ContactRenderer::solved(const std::vector<ContactFocus>& foci, double most_Pa)
{
    RenderedField rendered;
    std::vector<ContactFocus> played = foci;
    for (ContactFocus& focus : played)
    {
        focus.pressure_Pa *= focus.share;
        if (most_Pa > 0.0) focus.pressure_Pa = std::min(focus.pressure_Pa, most_Pa);
    }
    rendered.isFailed = !_field.solve(played, rendered.q, &rendered.error);
    rendered.report = _field.report();
    rendered.foci = pointsWithObjects(rendered.isFailed ? std::vector<ContactFocus>() : foci);
    return rendered;
}

RenderedField ContactRenderer::render(double now_s,
                                      const haptics::FieldSequence& whole,
                                      double most_Pa,
                                      double rate_Hz)
{
    advance(now_s, most_Pa, rate_Hz, nullptr);
    RenderedField rendered = solved(_foci, most_Pa);
    if (rendered.isFailed) _foci.clear();
    addWhole(now_s, whole, rendered.q);
    _wasActive = isActive(now_s);
    return rendered;
}

std::optional<SteadyTurn> ContactRenderer::steady(double most_Pa) const
{
    const std::vector<Contact>& contacts = _tracker.contacts();
    const bool isTouched = std::any_of(
        contacts.begin(), contacts.end(), [this](const Contact& one) { return presses(one); });
    const bool isElse = isTouched || isWholePlayed() || _shares.isFading() || !areOfSensations();
    if (!_wasActive || isElse) return std::nullopt;
    return _sensations.steady(most_Pa);
}

std::vector<RenderedField> ContactRenderer::render(const SteadyTurn& steady,
                                                   const haptics::StoredTurn& turn)
{
    std::vector<RenderedField> fields;
    for (int field = 0; field < turn.fields; ++field)
    {
        fields.push_back(solved(steady.foci(turn, field), 0.0));
        if (fields.back().isFailed) break;
    }
    return fields;
}

void ContactRenderer::keep(double now_s, Eigen::VectorXcf played)
{
    _recent.push_back(std::make_shared<const TimedField>(TimedField{now_s, std::move(played)}));
    while (_recent.front()->time_s < now_s - ContactScene::kRecent_s)
        _recent.pop_front();
}

void ContactRenderer::keepTurn(double now_s, double rate_Hz, std::vector<Eigen::VectorXcf> played)
{
    _recent.clear();
    const auto fields = static_cast<double>(played.size());
    for (Eigen::VectorXcf& field : played)
    {
        const double ago_s = (fields - static_cast<double>(_recent.size())) / rate_Hz;
        _recent.push_back(
            std::make_shared<const TimedField>(TimedField{now_s - ago_s, std::move(field)}));
    }
}

double ContactRenderer::whole() const
{
    return _wasActive ? _levels.whole : _shares.mostWhole();
}

ContactScene ContactRenderer::view() const
{
    ContactScene scene;
    scene.whole = whole();
    scene.sensations = _sensations.views();
    scene.recent.assign(_recent.begin(), _recent.end());
    for (const Contact& contact : _tracker.contacts())
    {
        ContactView& view = scene.contacts.emplace_back();
        view.id = contact.id;
        view.patch = contact.path.patch();
        view.pathMajor_m = contact.path.semiMajor_m();
        view.pathMinor_m = contact.path.semiMinor_m();
        view.speed_m_s = contact.speed_m_s;
        view.share = _shares.contacts(view.patch.object);
        std::vector<ContactFocus> own;
        for (const ContactFocus& focus : _foci)
            if (focus.contact == contact.id) own.push_back(focus);
        const haptics::ControlPoints points = pointsWithObjects(own);
        view.foci = points.positions;
        view.pressure_Pa = points.targets.cast<double>();
    }
    return scene;
}

std::vector<std::string> ContactRenderer::problems() const
{
    std::vector<std::string> problems;
    for (const ContactNote& note : _tracker.notes())
    {
        if (note.reason == ContactReason::NONE || note.reason == ContactReason::MESH_NOT_READY)
            continue;
        const std::string where = note.bone >= 0 ? " at " + boneName(note.bone) : "";
        problems.push_back(fmt::format(
            "contact of hand {}{}: {}", note.hand, where, contactReasonText(note.reason)));
    }
    return problems;
}

} // namespace midair::bridge
