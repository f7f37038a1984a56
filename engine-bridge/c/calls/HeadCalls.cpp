// midair_set_head() and related calls, and the coincidence errors.
#include "engine-bridge/c/inside/Calls.h"
#include "engine-bridge/c/inside/OwnSource.h"
#include "engine-bridge/c/inside/Scene.h"
#include "engine-bridge/heads/HeadOpening.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

using namespace midair;
using namespace midair::capi;

namespace
{

static_assert(std::size(bridge::kCoincidenceParts) == MIDAIR_PART_TOTAL);
static_assert(static_cast<int>(bridge::CoincidencePart::NONE) == MIDAIR_PART_NONE);

template<std::size_t Size>
void copyText(const std::string& text, char (&to)[Size])
{
    std::memcpy(to, text.data(), std::min(text.size(), Size - 1));
}

midair_coincidence coincidenceForC(const bridge::CoincidenceFigures& figures)
{
    midair_coincidence made{};
    made.object = figures.id;
    const auto put = [&](std::size_t index, const bridge::CoincidencePart& part)
    {
        made.median_m[index] = 1e-3 * part.median_mm;
        made.most_m[index] = 1e-3 * part.most_mm;
        made.state[index] = part.state;
    };
    std::size_t index = 0;
    for (const bridge::CoincidenceRow& row : bridge::kCoincidenceParts)
        put(index++, figures.*row.part);
    put(MIDAIR_PART_TOTAL, figures.total);
    copyText(figures.largest, made.largest);
    copyText(figures.unknown, made.unknown);
    return made;
}

/// Converts a head of the application; fails for an invalid one.
bridge::Head headOf(const midair_head& given)
{
    const Eigen::Vector3d place(Eigen::Vector3d::Map(given.position));
    const Eigen::Quaterniond turn(Eigen::Vector4d(Eigen::Vector4d::Map(given.orientation)));
    if (!(place.norm() <= bridge::kFarthestJoint_m)) // also false for NaN
        fail(MIDAIR_INVALID,
             fmt::format("the head is at ({:g}, {:g}, {:g}) m; it must be within 1000 m",
                         place.x(),
                         place.y(),
                         place.z()));
    if (!(std::abs(turn.norm() - 1.0) < 1e-3))
        fail(MIDAIR_INVALID,
             fmt::format("the head's orientation has the length {:g}; it must be 1", turn.norm()));
    if (!(given.age_s >= 0.0 && given.age_s <= 1e6))
        fail(MIDAIR_INVALID,
             fmt::format("the head's age_s is {:g}; it must be 0 .. 1e6", given.age_s));
    return {0.0, bridge::headPose(place, turn), true, given.age_s};
}

/// A head source of the application.
class OwnHead : public bridge::HeadSource
{
public:
    OwnHead(const midair_head_source& source, const std::string& options) : _source(source, options)
    {
    }

    bool headAt(double time_s, bridge::Head& head) override
    {
        midair_head given{};
        given.orientation[3] = 1.0;
        int32_t isTracked = 0;
        {
            const CallbackScope inside;
            isTracked = _source.callbacks().head(_source.instance(), time_s, &given);
        }
        head = isTracked > 0 ? headOf(given) : bridge::Head();
        head.time_s = time_s;
        return head.isTracked;
    }
    std::string status() const override { return "a head source of the application"; }

private:
    const OwnSource<midair_head_source> _source;
};

/// Takes the head from \a source from now on; null: from midair_set_head().
void takeHeadFrom(Scene& scene, std::shared_ptr<bridge::HeadSource> source)
{
    std::shared_ptr<bridge::HeadSource> before; // destroyed without the mutex
    const base::Lock lock(scene.mutex);
    if (scene.isClosed) fail(MIDAIR_CLOSED, "the midair_scene is closed, or none");
    before = scene.player.heads().active();
    scene.player.setHeadSource(nullptr); // its last position no longer counts
    scene.player.setHeadSource(source ? std::move(source) : scene.head);
}

} // namespace

midair_status midair_register_head(const char* name, const midair_head_source* source)
{
    return called(
        [&]
        {
            const std::string registered = textGiven(name, "name", 256);
            const midair_head_source& all = given(source, "source");
            requireSize(all);
            if (!all.open || !all.head) fail(MIDAIR_INVALID, "open or head is NULL");
            std::string error;
            const auto open = [copy = all](const std::string& options)
            { return std::make_shared<OwnHead>(copy, options); };
            if (!bridge::registerHeads(registered, open, error)) fail(MIDAIR_REFUSED, error);
        });
}

midair_status midair_set_head(midair_scene* scene, const midair_head* head)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            of->head->clear(); // so that no old head remains after an error
            if (head)
            {
                bridge::Head seen = headOf(*head);
                seen.time_s = base::steadySeconds();
                of->head->set(seen);
                return;
            }
            const base::Lock lock(of->mutex);
            if (of->player.heads().active() != of->head) return;
            of->player.setHeadSource(nullptr);
            of->player.setHeadSource(of->head);
        });
}

midair_status midair_open_head(midair_scene* scene, const char* source)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const std::string text = textGiven(source, "source", 4096);
            if (const std::string why = bridge::unknownHead(text); !why.empty())
                fail(MIDAIR_UNKNOWN, why);
            takeHeadFrom(*of, bridge::openHead(text));
        });
}

midair_status midair_set_display(midair_scene* scene, const char* file)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const std::string path = textGiven(file, "file", 4096);
            std::shared_ptr<const bridge::Display> display;
            if (!path.empty())
                display = std::make_shared<const bridge::Display>(bridge::loadDisplay(path));
            // "scene": the eye is this scene's own head.
            bool opensEye = display && !display->eye.empty() && display->eye != "scene";
            {
                const base::Lock lock(of->mutex);
                of->display = display;
                bridge::Head set;
                opensEye = opensEye && of->player.heads().active() == of->head &&
                           !of->head->headAt(base::steadySeconds(), set);
            }
            if (opensEye) takeHeadFrom(*of, bridge::openHead(display->eye));
        });
}

midair_status midair_list_coincidence(midair_scene* scene,
                                      midair_coincidence* list,
                                      size_t capacity,
                                      size_t* count)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            const std::vector<bridge::CoincidenceFigures> all =
                of->device.empty() ? std::vector<bridge::CoincidenceFigures>()
                                   : of->player.coincidence();
            return copyAll(all, list, capacity, count, coincidenceForC);
        });
}

midair_status midair_last_head(midair_scene* scene, midair_head* head)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            given(head, "head") = {};
            const base::Lock lock(of->mutex);
            const bridge::Head& last = of->player.heads().head();
            if (!last.isTracked) fail(MIDAIR_NOT_YET, "no head is tracked");
            Eigen::Vector3d::Map(head->position) = last.pose.translation();
            Eigen::Vector4d::Map(head->orientation) =
                Eigen::Quaterniond(last.pose.linear()).coeffs();
            head->age_s = last.age_s;
        });
}
