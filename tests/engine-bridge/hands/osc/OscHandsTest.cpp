#include "haptics/base/InputError.h"
#include "tests/engine-bridge/hands/osc/OscDatagrams.h"

#include <cmath>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

namespace midair::bridge
{

namespace
{

OscContent decode(const std::string& bytes)
{
    return decodeOsc(bytes.data(), bytes.size());
}

std::string errorOf(const std::string& bytes)
{
    try
    {
        decode(bytes);
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return "nothing";
}

/// The bytes at the end of a page that has none behind it: a read beyond them ends the program.
class AtTheEdge
{
public:
    explicit AtTheEdge(const std::string& bytes) :
        _page(static_cast<std::size_t>(::sysconf(_SC_PAGESIZE))),
        _room(::mmap(nullptr, 4 * _page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0))
    {
        ::mprotect(_room, 3 * _page, PROT_READ | PROT_WRITE);
        data = static_cast<char*>(_room) + 3 * _page - bytes.size();
        std::memcpy(data, bytes.data(), bytes.size());
    }
    ~AtTheEdge() { ::munmap(_room, 4 * _page); }
    AtTheEdge(const AtTheEdge&) = delete;
    AtTheEdge& operator=(const AtTheEdge&) = delete;

    char* data;

private:
    std::size_t _page;
    void* _room;
};

} // namespace

TEST(OscHands, ComeAsTheyWereSent)
{
    Hand left = handAt(0, -0.03);
    left.age_s = 0.012;
    left.joints[LITTLE_TIP].positionValid = false;
    left.joints[RING_TIP].orientationValid = false;
    left.joints[PALM].orientation = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 2).normalized());
    const Hand right = handAt(1, 0.04);
    const OscContent content = decode(datagramOf({left, right}, 123456.789012));
    ASSERT_EQ(content.hands.size(), 2U);
    EXPECT_EQ(content.hands[0].time_s, 123456.789012);
    EXPECT_EQ(content.hands[0].hand.id, 0);
    EXPECT_EQ(content.hands[1].hand.id, 1);
    EXPECT_NEAR(content.hands[0].hand.age_s, 0.012, 1e-8);
    for (std::size_t i = 0; i < HAND_JOINTS; ++i)
    {
        const HandJoint& sent = left.joints[i];
        const HandJoint& got = content.hands[0].hand.joints[i];
        EXPECT_EQ(got.positionValid, i != LITTLE_TIP);
        EXPECT_EQ(got.orientationValid, sent.orientationValid);
        EXPECT_NEAR(got.radius_m, sent.radius_m, 1e-9);
        // Floats within a metre: 2^-24 m.
        if (!got.positionValid) continue;
        EXPECT_LT((got.position - sent.position).norm(), 1.1e-7);
        if (!got.orientationValid) continue;
        EXPECT_LT(got.orientation.angularDistance(sent.orientation), 1e-6);
    }
    EXPECT_LT(datagramOf({left, right}, 1.0).size(), 2700U);
}

TEST(OscHands, AMessageAndABundleInABundleDoAsWell)
{
    EXPECT_EQ(decode(HandMessage().bytes()).hands.size(), 1U);
    std::string inside = datagramOf({handAt(1, 0.0)}, 2.0);
    const auto wrapped = [](const std::string& element)
    {
        const auto size = static_cast<std::uint32_t>(element.size());
        std::string bytes("#bundle\0\0\0\0\0\0\0\0\1", 16);
        for (int shift = 24; shift >= 0; shift -= 8)
            bytes += static_cast<char>(size >> shift);
        return bytes + element;
    };
    EXPECT_EQ(decode(wrapped(inside)).hands.size(), 1U);
    for (int i = 0; i < 4; ++i)
        inside = wrapped(inside);
    EXPECT_EQ(errorOf(inside), "bundles more than 4 deep");
}

TEST(OscHands, SayWhatIsWrong)
{
    HandMessage message;
    message.side = "middle\n";
    EXPECT_EQ(errorOf(message.bytes()),
              "/midair/hand: the side is \"middle?\", should be left or right");
    message = {};
    message.joints = 25;
    EXPECT_EQ(errorOf(message.bytes()), "/midair/hand: the little tip is missing");
    message.joints = 27;
    EXPECT_EQ(errorOf(message.bytes()), "/midair/hand has more arguments than it should");
    message = {};
    message.age_s = -1.0F;
    EXPECT_EQ(errorOf(message.bytes()), "/midair/hand: the age is -1 s, should be 0 .. 10");
    message = {};
    message.isText = true;
    EXPECT_EQ(errorOf(message.bytes()), "/midair/hand: the age should be a number: f, d or i");
    message = {};
    message.time_s = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(errorOf(message.bytes()), "/midair/hand: the time is nan, should be seconds");
    EXPECT_EQ(errorOf(std::string(kMostOscBytes + 4, 'x')), "8196 bytes, should be up to 8192");
    // Of a blob's length oscpack doesn't ask whether it is within the datagram.
    const std::string blob = std::string("/midair/hand\0\0\0\0,b\0\0", 20) + "\x7F\xFF\xFF\xFF";
    EXPECT_EQ(errorOf(blob), "/midair/hand: an argument of type b, should be of f, d, i or s");
    EXPECT_EQ(errorOf("").substr(0, 7), "no OSC:");
    EXPECT_EQ(errorOf("/midair/hand").substr(0, 7), "no OSC:");
}

TEST(OscHands, ImpossibleJointsAreLeftOutAndNoNumberGetsIn)
{
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const auto& [x, w, radius] : {std::array<float, 3>{nan, 1.0F, 0.007F},
                                       std::array<float, 3>{2000.0F, 1.0F, 0.007F},
                                       std::array<float, 3>{0.1F, 1.0F, 0.2F},
                                       std::array<float, 3>{0.1F, 1.0F, nan},
                                       std::array<float, 3>{0.1F, 1.0F, 0.0F}})
    {
        HandMessage message;
        message.x = x;
        message.w = w;
        message.radius = radius;
        const OscContent content = decode(message.bytes());
        EXPECT_EQ(content.jointsLeftOut, 26U);
        EXPECT_NE(content.firstLeftOut.find("impossible palm"), std::string::npos);
        for (const HandJoint& joint : content.hands.at(0).hand.joints)
        {
            EXPECT_FALSE(joint.positionValid);
            EXPECT_TRUE(joint.position.allFinite() && std::isfinite(joint.radius_m));
        }
    }
    HandMessage message;
    message.w = nan;
    const OscContent content = decode(message.bytes());
    EXPECT_TRUE(content.hands.at(0).hand.joints[0].positionValid);
    EXPECT_FALSE(content.hands.at(0).hand.joints[0].orientationValid);
    EXPECT_TRUE(content.hands.at(0).hand.joints[0].orientation.coeffs().allFinite());
}

TEST(OscHands, OfADatagramThatIsTornNothingCounts)
{
    const std::string whole = datagramOf({handAt(0, 0.0), handAt(1, 0.1)}, 1.0);
    int hands = 0;
    for (std::size_t size = 0; size < whole.size(); ++size)
    {
        const AtTheEdge torn(whole.substr(0, size));
        try
        {
            const OscContent content = decodeOsc(torn.data, size);
            hands += static_cast<int>(content.hands.size());
            // Only where a message ends is it a bundle.
            EXPECT_TRUE(size == 16 || content.hands.size() == 1) << size;
        }
        catch (const base::InputError&)
        {
        }
    }
    EXPECT_EQ(hands, 1);
}

TEST(OscHands, NothingIsReadBeyondTheEnd)
{
    const std::string whole = datagramOf({handAt(0, 0.0), handAt(1, 0.1)}, 1.0);
    // Each of the first bytes, where lengths and types are, as any byte that matters to a parser.
    for (std::size_t at = 0; at < 420; ++at)
        for (const char value : {'\0', '\1', '\x7F', '\x80', '\xFF', 'b', 's', ',', '[', ']'})
        {
            std::string changed = whole;
            changed[at] = value;
            const AtTheEdge edge(changed);
            try
            {
                decodeOsc(edge.data, changed.size());
            }
            catch (const base::InputError& error)
            {
                EXPECT_NE(*error.what(), '\0');
            }
        }
}

TEST(OscHands, OtherAddressesAreNamed)
{
    std::vector<char> room(200);
    osc::OutboundPacketStream out(room.data(), room.size());
    out << osc::BeginMessage("/midair/hands") << 1.0F << osc::EndMessage;
    const OscContent content = decodeOsc(out.Data(), out.Size());
    EXPECT_EQ(content.unknown, "\"/midair/hands\" (did you mean /midair/hand?)");
    EXPECT_EQ(content.unknownCount, 1U);
}

} // namespace midair::bridge
