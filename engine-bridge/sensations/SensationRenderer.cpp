#include "engine-bridge/sensations/SensationRenderer.h"

#include "haptics/sensation/SensationFigures.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

constexpr std::uint64_t kFirstContact = std::uint64_t(1) << 40; // above those of all touches
constexpr double kRise_s = 2.0;     // from a capped level to the full one
constexpr double kMeasure_m = 5e-3; // a strength is that of all places so near
constexpr std::size_t kMostHeeded = 10000;

bool hasPattern(const HapticObject& object)
{
    return object.properties.sensation.isMeant && object.properties.sensation.pattern;
}

/// Returns true if a device plays a frequency noticeably wrong; it is left out where \a played_Hz
/// is 0.
bool isPlayedOff(double played_Hz, double wanted_Hz)
{
    const double wanted = std::abs(wanted_Hz);
    return played_Hz > 0.0 && wanted > 0.0 &&
           std::abs(played_Hz - wanted) > haptics::kToldTurnError * wanted;
}

bool needsSurface(const HapticObject& object)
{
    return object.mesh && object.mesh->triangles.cols() > 0;
}

} // namespace

SensationRenderer::SensationRenderer(const haptics::TransducerArray& array,
                                     const haptics::Medium& medium) :
    _medium(medium)
{
    setArray(array);
}

void SensationRenderer::setArray(const haptics::TransducerArray& array)
{
    _matrix.bind(array, _medium);
    _matrix.resize(1);
    for (auto& [object, item] : _items)
        item.measured.setConstant(std::nan(""));
}

bool SensationRenderer::concerns(const std::vector<HapticObject>& objects)
{
    return std::any_of(objects.begin(),
                       objects.end(),
                       [](const HapticObject& object)
                       { return object.properties.sensation.isMeant; });
}

void SensationRenderer::update(const std::vector<HapticObject>& objects,
                               const HandFrame& hands,
                               const std::vector<Contact>& contacts,
                               double time_s)
{
    ++_updates;
    _meshes.beginUpdate();
    for (std::size_t i = 0; i < objects.size(); ++i)
    {
        const HapticObject& object = objects[i];
        if (!hasPattern(object)) continue;
        Item& item = itemOf(object);
        if (item.seen == _updates) continue; // another part
        item.seen = _updates;
        item.index = static_cast<int>(i);
        std::shared_ptr<const MeshDistance> surface;
        if (needsSurface(object)) surface = _meshes.get(object);
        item.sensation.update(object, {hands, contacts, std::move(surface), time_s});
    }
    _meshes.endUpdate();
    if (_heeded.size() > kMostHeeded) _heeded.clear();
    for (auto item = _items.begin(); item != _items.end();)
    {
        if (item->second.seen == _updates)
        {
            ++item;
            continue;
        }
        _heeded[item->first] = item->second.sensation.heeded();
        item = _items.erase(item);
    }
}

SensationRenderer::Item& SensationRenderer::itemOf(const HapticObject& object)
{
    const std::uint64_t id = object.touchId();
    auto found = _items.find(id);
    if (found != _items.end() && !found->second.sensation.isOther(object)) return found->second;
    if (found != _items.end()) _heeded[id] = found->second.sensation.heeded();
    _items.erase(id);
    const auto heeded = _heeded.find(id);
    const int plays = heeded == _heeded.end() ? 0 : heeded->second;
    return _items
        .emplace(id,
                 Item{PlayingSensation(object, kFirstContact + ++_made, plays),
                      object.path,
                      object.origin})
        .first->second;
}

void SensationRenderer::clear()
{
    for (const auto& [object, item] : _items)
        _heeded[object] = item.sensation.heeded();
    _items.clear();
    _capped = 1.0;
}

void SensationRenderer::continueFrom(SensationRenderer& before)
{
    _items.swap(before._items);
    _heeded.swap(before._heeded);
    _made = before._made;
    _updates = before._updates;
    for (auto& [object, item] : _items)
        item.measured.setConstant(std::nan("")); // the array may be another one
}

void SensationRenderer::pause()
{
    for (auto& [object, item] : _items)
        item.level = 0.0;
}

bool SensationRenderer::isActive() const
{
    return std::any_of(_items.begin(),
                       _items.end(),
                       [](const auto& one) { return one.second.sensation.isPlaying(); });
}

int SensationRenderer::highestPriority(int lowest) const
{
    int highest = lowest;
    for (const auto& [object, item] : _items)
        if (item.sensation.isPlaying()) highest = std::max(highest, item.sensation.priority());
    return highest;
}

// Conjugate phases add all amplitudes: sum_i |G_i|.
double SensationRenderer::mostAt(const Eigen::Vector3d& place)
{
    if (!place.allFinite()) return 0.0;
    _matrix.setPoint(0, place);
    const int row = 0;
    double sum = 0.0;
    for (int block = 0; block < _matrix.blocks(); ++block)
        _matrix.buildRows(block, &row, 1, &sum);
    return sum * _matrix.unit_Pa();
}

// Of intensity 1, in Pa.
double SensationRenderer::pressureOf(Item& item)
{
    const HapticProperties& properties = item.sensation.properties();
    if (properties.pressureInPa) return properties.pressure;
    const Eigen::Vector3d place = item.sensation.middle();
    if (!((place - item.measured).norm() <= kMeasure_m))
    {
        item.measured = place;
        item.most_Pa = mostAt(place);
    }
    return properties.pressure * item.most_Pa;
}

void SensationRenderer::render(double now_s,
                               double dt_s,
                               double rate_Hz,
                               const haptics::StoredTurn* turn,
                               double most_Pa,
                               Precedence& levels,
                               std::vector<ContactFocus>& foci)
{
    _rate_Hz = rate_Hz;
    _turn = turn ? std::optional<haptics::StoredTurn>(*turn) : std::nullopt;
    const haptics::SensationCarried carried =
        turn ? turn->carried() : haptics::SensationCarried::at(rate_Hz);
    std::vector<Item*> playing;
    for (auto& [object, item] : _items)
    {
        item.isLeftOut = false;
        item.level = 0.0;
        if (item.sensation.isPlaying()) playing.push_back(&item);
    }
    std::stable_sort(playing.begin(),
                     playing.end(),
                     [](const Item* a, const Item* b)
                     { return a->sensation.priority() > b->sensation.priority(); });
    std::size_t used = 0;
    for (Item* item : playing)
    {
        const bool isFull = used >= kMostFoci;
        item->pressure_Pa = pressureOf(*item);
        item->level = isFull ? 0.0 : levels.level(item->sensation.priority());
        std::vector<ContactFocus> own;
        item->sensation.render(now_s, dt_s, item->level * item->pressure_Pa, carried, own);
        item->isLeftOut = isFull && item->sensation.intensity() > 0.0;
        used += own.empty() ? 0 : 1;
        for (ContactFocus& focus : own)
        {
            focus.share = _capped * item->shareWithin(most_Pa);
            foci.push_back(focus);
        }
    }
}

// A cap lowers a turn as a whole, so that what earlier fields were lowered by doesn't count.
std::optional<SteadyTurn> SensationRenderer::steady(double most_Pa) const
{
    std::vector<SteadyPart> parts;
    for (const auto& [object, item] : _items)
    {
        if (!item.sensation.isPlaying() || item.isLeftOut) continue;
        std::optional<SteadyPart> part = item.sensation.steady(item.pressure_Pa);
        if (!part || item.level < 1.0) return std::nullopt;
        part->focus.share = item.shareWithin(most_Pa);
        parts.push_back(std::move(*part));
    }
    if (parts.empty()) return std::nullopt;
    return SteadyTurn(std::move(parts));
}

haptics::PlayedAs SensationRenderer::playedAs() const
{
    bool isModulated = false, isHeld = false;
    for (const auto& [object, item] : _items)
    {
        if (item.level == 0.0 || item.sensation.intensity() == 0.0) continue;
        const haptics::SensationSample& now = item.sensation.sample();
        const bool isDrawn = now.brush.isDrawn() && now.brush.draw_Hz != 0.0;
        if (isDrawn && !now.isOutline) return haptics::PlayedAs::CIRCLING;
        isModulated = isModulated || (now.brush.modulation_Hz != 0.0 && !now.isUnmodulated);
        isHeld = isHeld || now.isOutline;
    }
    if (isModulated) return haptics::PlayedAs::VIBRATING;
    return isHeld ? haptics::PlayedAs::HELD : haptics::PlayedAs::CIRCLING;
}

void SensationRenderer::noteCap(double factor, double dt_s)
{
    _capped =
        factor < 1.0 ? _capped * std::max(factor, 0.0) : std::min(_capped + dt_s / kRise_s, 1.0);
}

std::vector<SensationView> SensationRenderer::views() const
{
    std::vector<SensationView> all;
    for (const auto& [object, item] : _items)
    {
        SensationView& view = all.emplace_back(item.sensation.view());
        view.index = item.index;
        view.intensity *= item.level;
        view.pressure_Pa = item.pressure_Pa * view.intensity;
        if (item.level == 0.0) view.trail.clear();
    }
    return all;
}

std::vector<base::Message> SensationRenderer::problems() const
{
    std::vector<base::Message> all;
    for (const auto& [object, item] : _items)
    {
        const PlayingSensation::Limited& limited = item.sensation.limited();
        if (!item.sensation.isPlaying()) continue;
        std::vector<std::string> whys;
        if (limited.isBroken)
            whys.emplace_back("a formula of its sensation gives no number; it is silent there");
        if (limited.isOutOfRange)
            whys.emplace_back(
                "its sensation asks for an intensity outside 0 .. 1, which is limited");
        if (limited.outline_Hz != 0.0)
            whys.push_back(fmt::format("its brush turns {:g} times a second, and {:.3g} fields a "
                                       "second are fewer than {:g} "
                                       "a turn; its outline is played instead",
                                       limited.outline_Hz,
                                       _rate_Hz,
                                       haptics::SensationFigures::kLeastPoints));
        if (limited.modulation_Hz != 0.0)
            whys.push_back(fmt::format("its modulation of {:g} Hz is left out: {:.3g} fields a "
                                       "second are fewer than {:g} a "
                                       "period",
                                       limited.modulation_Hz,
                                       _rate_Hz,
                                       haptics::SensationPlayer::kLeastOfPeriod));
        if (_turn && isPlayedOff(_turn->draw_Hz(), item.sensation.brush().draw_Hz))
            whys.push_back(fmt::format("the device turns its brush {:g} times a second, not {:g}",
                                       _turn->draw_Hz(),
                                       item.sensation.brush().draw_Hz));
        if (_turn && isPlayedOff(_turn->modulation_Hz(), item.sensation.brush().modulation_Hz))
            whys.push_back(fmt::format("the device modulates it by {:g} Hz, not {:g}",
                                       _turn->modulation_Hz(),
                                       item.sensation.brush().modulation_Hz));
        if (item.isLeftOut)
            whys.push_back(fmt::format(
                "it isn't played: {} sensations have a focus already, those of higher priority",
                kMostFoci));
        for (const std::string& why : whys)
            all.push_back(
                base::about(base::MessageCode::SENSATION_LIMITED, item.path, why, item.origin));
    }
    return all;
}

} // namespace midair::bridge
