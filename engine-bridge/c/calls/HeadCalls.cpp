// midair_set_head() and its like.
#include "engine-bridge/c/inside/Calls.h"
#include "engine-bridge/c/inside/Scene.h"
#include "engine-bridge/heads/HeadOpening.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/threads/SteadyClock.h"

#include <array>
#include <cmath>

#include <fmt/format.h>

using namespace midair;
using namespace midair::capi;

namespace
{

/// Returns a head of the application's; fails for one that can't be.
bridge::Head headOf(const midair_head& given)
{
    const Eigen::Vector3d place(Eigen::Vector3d::Map(given.position));
    const Eigen::Quaterniond turn(Eigen::Vector4d(Eigen::Vector4d::Map(given.orientation)));
    if (!(place.norm() <= bridge::kFarthestJoint_m)) // false for NaN, too
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

/// A head source of the application's.
class OwnHead : public bridge::HeadSource
{
public:
    OwnHead(const midair_head_source& source, const std::string& options) : _source(source)
    {
        const CallbackScope inside;
        std::array<char, 1024> error{};
        const std::string thrown = base::thrownBy(
            [&] {
                _instance =
                    _source.open(_source.user, options.c_str(), error.data(), error.size() - 1);
            });
        if (!thrown.empty()) fail(MIDAIR_REFUSED, "its open() has thrown " + thrown);
        if (!_instance)
            fail(MIDAIR_REFUSED,
                 error.front() ? std::string(error.data()) : "its open() returned NULL");
    }
    ~OwnHead() override
    {
        const CallbackScope inside;
        if (_source.close) base::thrownBy([&] { _source.close(_instance); });
    }
    OwnHead(const OwnHead&) = delete;
    OwnHead& operator=(const OwnHead&) = delete;

    bool headAt(double time_s, bridge::Head& head) override
    {
        midair_head given{};
        given.orientation[3] = 1.0;
        int32_t isTracked = 0;
        {
            const CallbackScope inside;
            isTracked = _source.head(_instance, time_s, &given);
        }
        head = isTracked > 0 ? headOf(given) : bridge::Head();
        head.time_s = time_s;
        return head.isTracked;
    }
    std::string status() const override { return "a head source of the application"; }

private:
    const midair_head_source _source;
    void* _instance = nullptr;
};

/// Takes the head from \a source from now on; null: from midair_set_head().
void takeHeadFrom(Scene& scene, std::shared_ptr<bridge::HeadSource> source)
{
    std::shared_ptr<bridge::HeadSource> before; // dies without the mutex
    const base::Lock lock(scene.mutex);
    if (scene.isClosed) fail(MIDAIR_CLOSED, "the midair_scene is closed, or none");
    before = scene.player.heads().active();
    scene.player.setHeadSource(nullptr); // where it was before counts no longer
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
            if (all.struct_size < sizeof(midair_head_source))
                fail(MIDAIR_INVALID,
                     fmt::format("struct_size is {}; it must be the struct's sizeof, {}",
                                 all.struct_size,
                                 sizeof(midair_head_source)));
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
            of->head->clear(); // so that an error leaves none that is old
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
