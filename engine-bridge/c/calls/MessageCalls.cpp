// Message functions of the C interface.
#include "engine-bridge/c/inside/Calls.h"
#include "engine-bridge/c/inside/Scene.h"

#include <algorithm>
#include <cstring>

#include <fmt/format.h>
#include <fmt/ranges.h>

using namespace midair;
using namespace midair::capi;

static_assert(static_cast<int>(base::Severity::FAULT) == MIDAIR_FAULT);

midair_message midair::capi::toPublic(const base::Message& message)
{
    midair_message told{};
    told.number = message.number;
    if (message.origin) told.object = *static_cast<const midair_object*>(message.origin.get());
    told.count = message.count;
    told.since_s = message.since_s;
    told.until_s = message.until_s;
    told.severity = static_cast<int32_t>(message.severity());
    told.active = message.isActive ? 1 : 0;
    const std::string name = base::kindOf(message.code).name;
    std::memcpy(told.code, name.data(), std::min(name.size(), sizeof told.code - 1));
    return told;
}

midair_status midair_messages(midair_scene* scene, char* text, size_t size, size_t* needed)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            of->player.takeResult();
            return writeText(
                fmt::format("{}", fmt::join(of->player.log().all(), "\n")), text, size, needed);
        });
}

midair_status
midair_list_messages(midair_scene* scene, midair_message* messages, size_t capacity, size_t* count)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            of->player.takeResult();
            return copyAll(of->player.log().messages(), messages, capacity, count, toPublic);
        });
}

midair_status
midair_message_text(midair_scene* scene, uint64_t number, char* text, size_t size, size_t* needed)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            for (const base::Message& message : of->player.log().messages())
                if (message.number == number) return writeText(message.text, text, size, needed);
            fail(MIDAIR_UNKNOWN, fmt::format("the scene has no message {}", number));
        });
}

midair_status midair_clear_messages(midair_scene* scene)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            of->player.log().forgetEnded();
        });
}

midair_status midair_on_message(midair_scene* scene, midair_message_callback callback, void* user)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            const base::Lock lock(of->mutex);
            of->listener = {callback, user, 0};
        });
}
