// midair_register_hands().
#include "engine-bridge/c/inside/OwnHands.h"

#include "engine-bridge/c/inside/Calls.h"
#include "engine-bridge/hands/opening/HandOpening.h"
#include "haptics/base/ThrownBy.h"

#include <array>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

using namespace midair;
using namespace midair::capi;

namespace midair::capi
{

namespace
{

/// A hand source of the application's.
class OwnHands : public bridge::HandSource
{
public:
    OwnHands(const midair_hand_source& source, const std::string& options) : _source(source)
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
    ~OwnHands() override
    {
        const CallbackScope inside;
        if (_source.close) base::thrownBy([&] { _source.close(_instance); });
    }
    OwnHands(const OwnHands&) = delete;
    OwnHands& operator=(const OwnHands&) = delete;

    bool frameAt(double time_s, bridge::HandFrame& frame) override
    {
        frame.hands.clear();
        int32_t count = -1;
        {
            const CallbackScope inside;
            _hands.assign(kMostHands, midair_hand{});
            count = _source.hands(_instance, time_s, _hands.data(), _hands.size());
        }
        if (count > static_cast<int32_t>(_hands.size()))
            throw std::runtime_error(
                fmt::format("{} hands, where there is room for {}", count, _hands.size()));
        for (int32_t i = 0; i < count; ++i)
            frame.hands.push_back(
                handOf(_hands[static_cast<std::size_t>(i)], static_cast<std::size_t>(i)));
        return count > 0;
    }
    std::string status() const override { return "a hand source of the application"; }

private:
    static constexpr std::size_t kMostHands = 8;

    const midair_hand_source _source;
    void* _instance = nullptr;
    std::vector<midair_hand> _hands;
};

} // namespace

} // namespace midair::capi

midair_status midair_register_hands(const char* name, const midair_hand_source* source)
{
    return called(
        [&]
        {
            const std::string registered = textGiven(name, "name", 256);
            const midair_hand_source& all = given(source, "source");
            if (all.struct_size < sizeof(midair_hand_source))
                fail(MIDAIR_INVALID,
                     fmt::format("struct_size is {}; it must be the struct's sizeof, {}",
                                 all.struct_size,
                                 sizeof(midair_hand_source)));
            if (!all.open || !all.hands) fail(MIDAIR_INVALID, "open or hands is NULL");
            std::string error;
            const auto open = [copy = all](const std::string& options)
            { return std::make_shared<OwnHands>(copy, options); };
            if (!bridge::registerHands(registered, open, error)) fail(MIDAIR_REFUSED, error);
            return MIDAIR_OK;
        });
}
