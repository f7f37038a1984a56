// Uses oscpack for reading and writing: it reads in place, allocates nothing, throws on malformed
// data, and leaves sockets to its user. liblo, the larger library in Debian, copies each message to
// the heap, listens on all addresses of the machine, and calls handlers by patterns that the sender
// may choose. oscpack 1.1 doesn't check the length of blobs, and reads beyond the datagram;
// therefore messages with arguments other than those of hands are refused before it sees them.
#include "engine-bridge/hands/osc/OscHands.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>
#include <oscpack/osc/OscOutboundPacketStream.h>
#include <oscpack/osc/OscReceivedElements.h>

namespace midair::bridge
{

namespace
{

constexpr int kDeepestBundle = 4;
constexpr std::size_t kMostMessages = 32; ///< per datagram
constexpr std::size_t kMostText = 1000;
constexpr double kLatest_s = 1e15; ///< later times have no milliseconds in a double
constexpr int kPositionValid = 1;
constexpr int kOrientationValid = 2;
constexpr double kQuaternionError = 0.01; ///< of its length; floats are more exact

/// \a text for messages: replaces non-printable characters and cuts it.
std::string shown(const char* text, std::size_t most = 60)
{
    std::string result(text, ::strnlen(text, most));
    std::replace_if(
        result.begin(), result.end(), [](char c) { return c < 0x20 || c > 0x7E; }, '?');
    return result;
}

/// The arguments of a message in order; each getter throws base::InputError.
class Arguments
{
public:
    explicit Arguments(const osc::ReceivedMessage& message) :
        _address(message.AddressPattern()),
        _next(message.ArgumentsBegin()),
        _end(message.ArgumentsEnd())
    {
    }

    /// A float, a double or an int32, whichever was sent.
    double number(const char* what)
    {
        const osc::ReceivedMessageArgument one = take(what);
        if (one.IsFloat()) return static_cast<double>(one.AsFloatUnchecked());
        if (one.IsDouble()) return one.AsDoubleUnchecked();
        if (one.IsInt32()) return one.AsInt32Unchecked();
        throw error(what, "should be a number: f, d or i");
    }

    int wholeNumber(const char* what)
    {
        const osc::ReceivedMessageArgument one = take(what);
        if (one.IsInt32()) return one.AsInt32Unchecked();
        if (one.IsFloat() && one.AsFloatUnchecked() == std::floor(one.AsFloatUnchecked()) &&
            std::abs(one.AsFloatUnchecked()) < 1e6F)
            return static_cast<int>(one.AsFloatUnchecked());
        throw error(what, "should be a whole number: i");
    }

    const char* text(const char* what)
    {
        const osc::ReceivedMessageArgument one = take(what);
        if (one.IsString()) return one.AsStringUnchecked();
        throw error(what, "should be a text: s");
    }

    void end() const
    {
        if (_next != _end)
            throw base::InputError(shown(_address) + " has more arguments than it should");
    }

    base::InputError error(const char* what, const std::string& why) const
    {
        return base::InputError(fmt::format("{}: the {} {}", shown(_address), what, why));
    }

private:
    osc::ReceivedMessageArgument take(const char* what)
    {
        if (_next == _end) throw error(what, "is missing");
        return *_next++;
    }

    const char* _address;
    osc::ReceivedMessageArgumentIterator _next;
    osc::ReceivedMessageArgumentIterator _end;
};

int sideOf(Arguments& arguments)
{
    const char* side = arguments.text("side");
    if (std::strcmp(side, "left") == 0) return 0;
    if (std::strcmp(side, "right") == 0) return 1;
    throw arguments.error("side", "is \"" + shown(side) + "\", should be left or right");
}

/// Removes a joint marked as valid but impossible from the hand; notes the reason.
void believe(HandJoint& joint, int number, OscContent& content)
{
    const double length = joint.orientation.norm();
    if (joint.orientationValid && !(std::abs(length - 1.0) <= kQuaternionError))
        joint.orientationValid = false;
    if (joint.orientationValid)
        joint.orientation.normalize();
    else
        joint.orientation.setIdentity();
    const double away_m = joint.position.norm();
    const bool isPlace = joint.position.allFinite() && away_m <= kFarthestJoint_m;
    const bool isSkin = joint.radius_m > 0.0 && joint.radius_m <= kThickestJoint_m;
    if (joint.positionValid && !(isPlace && isSkin) && content.jointsLeftOut++ == 0)
        content.firstLeftOut = fmt::format("an impossible {} ({:g} {:g} {:g}, radius {:g})",
                                           jointName(number),
                                           joint.position.x(),
                                           joint.position.y(),
                                           joint.position.z(),
                                           joint.radius_m);
    joint.positionValid = joint.positionValid && isPlace && isSkin;
    // Invalid members may hold any number; clears them for later readers.
    if (!joint.positionValid) joint.position.setZero();
    if (!isSkin) joint.radius_m = 0.0;
}

/// Takes the time and the age, each in its range.
void takeTimes(Arguments& arguments, double& time_s, double& age_s)
{
    time_s = arguments.number("time");
    if (!(std::abs(time_s) <= kLatest_s))
        throw arguments.error("time", fmt::format("is {:g}, should be seconds", time_s));
    age_s = arguments.number("age");
    if (!(age_s >= 0.0 && age_s <= kOldestOscHand_s))
        throw arguments.error(
            "age", fmt::format("is {:g} s, should be 0 .. {:g}", age_s, kOldestOscHand_s));
}

void takeHand(Arguments arguments, OscContent& content)
{
    OscContent::Timed timed;
    timed.hand.id = sideOf(arguments);
    takeTimes(arguments, timed.time_s, timed.hand.age_s);
    for (int i = 0; i < HAND_JOINTS; ++i)
    {
        HandJoint& joint = timed.hand.joints[static_cast<std::size_t>(i)];
        for (int k = 0; k < 3; ++k)
            joint.position[k] = arguments.number(jointName(i));
        for (int k = 0; k < 4; ++k) // x, y, z, w, as Eigen stores them
            joint.orientation.coeffs()[k] = arguments.number(jointName(i));
        joint.radius_m = arguments.number(jointName(i));
        const int valid = arguments.wholeNumber(jointName(i));
        joint.positionValid = (valid & kPositionValid) != 0;
        joint.orientationValid = (valid & kOrientationValid) != 0;
        believe(joint, i, content);
    }
    arguments.end();
    content.hands.push_back(timed);
}

/// Reads a head: its time and age, which are both optional, then its position and orientation.
void takeHead(Arguments arguments, std::size_t count, OscContent& content)
{
    constexpr std::size_t kOfPose = 7;
    Head head;
    head.time_s = std::nan("");
    if (count != kOfPose) takeTimes(arguments, head.time_s, head.age_s);
    Eigen::Vector3d place;
    Eigen::Quaterniond turn;
    for (double& number : place)
        number = arguments.number("head's place");
    for (double& number : turn.coeffs()) // x, y, z, w, as Eigen stores them
        number = arguments.number("head's turn");
    arguments.end();
    const bool isPlace = place.allFinite() && place.norm() <= kFarthestJoint_m;
    head.isTracked = isPlace && std::abs(turn.norm() - 1.0) <= kQuaternionError;
    if (head.isTracked)
    {
        head.pose = headPose(place, turn);
        content.head = head;
    }
    else if (content.jointsLeftOut++ == 0)
        content.firstLeftOut = fmt::format("an impossible head ({:g} {:g} {:g}, turn {:g} long)",
                                           place.x(),
                                           place.y(),
                                           place.z(),
                                           turn.norm());
}

/// Returns the text that begins at \a at, and moves \a at behind it: texts are padded with zeros to
/// a multiple of four. Throws if the terminator is missing.
std::string takeText(const char* data, std::size_t size, std::size_t& at)
{
    const void* end = at < size ? std::memchr(data + at, 0, size - at) : nullptr;
    if (!end) throw base::InputError("no OSC: a text has no end");
    const auto length = static_cast<std::size_t>(static_cast<const char*>(end) - (data + at));
    std::string text(data + at, length);
    at += (length / 4 + 1) * 4;
    return text;
}

/// Returns false for a message that isn't about hands or heads; throws for one with unsupported
/// argument types.
bool isOfHands(const char* data, std::size_t size, OscContent& content)
{
    std::size_t at = 0;
    const std::string address = takeText(data, size, at);
    if (address.compare(0, 1, "/") != 0) throw base::InputError("no OSC: it has no address");
    if (address != kOscHand && address != kOscHead && address != kOscText && address != kOscHorizon)
    {
        const std::string name = shown(address.c_str());
        if (content.unknownCount++ == 0)
            content.unknown =
                "\"" + name + "\"" + base::didYouMean(name, {kOscHand, kOscHead, kOscText});
        return false;
    }
    const std::string types = takeText(data, size, at);
    if (types.compare(0, 1, ",") != 0)
        throw base::InputError(address + " has no types of arguments");
    const std::size_t other = types.find_first_not_of("fdis", 1);
    if (other != std::string::npos)
        throw base::InputError(fmt::format("{}: an argument of type {}, should be of f, d, i or s",
                                           address,
                                           shown(types.substr(other, 1).c_str())));
    return true;
}

void takeMessage(const char* data, std::size_t size, OscContent& content)
{
    if (!isOfHands(data, size, content)) return;
    const osc::ReceivedMessage message{osc::ReceivedPacket(data, size)};
    const char* address = message.AddressPattern();
    Arguments arguments(message);
    if (std::strcmp(address, kOscHand) == 0)
        takeHand(arguments, content);
    else if (std::strcmp(address, kOscHead) == 0)
        takeHead(arguments, static_cast<std::size_t>(message.ArgumentCount()), content);
    else if (std::strcmp(address, kOscText) == 0)
        content.texts.push_back(shown(arguments.text("text"), kMostText));
    else
    {
        const double ahead_s = arguments.number("horizon");
        if (!(ahead_s >= 0.0 && ahead_s <= kFarthestOscHorizon_s))
            throw arguments.error("horizon", fmt::format("is {:g} s, should be 0 .. 1", ahead_s));
        content.horizon_s = ahead_s;
    }
}

void takeBundle(const osc::ReceivedBundle& bundle,
                int depth,
                std::size_t& left,
                OscContent& content)
{
    if (depth > kDeepestBundle)
        throw base::InputError(fmt::format("bundles more than {} deep", kDeepestBundle));
    for (auto element = bundle.ElementsBegin(); !(element == bundle.ElementsEnd()); ++element)
    {
        if (left-- == 0)
            throw base::InputError(fmt::format("more than {} messages", kMostMessages));
        if (element->IsBundle())
            takeBundle(osc::ReceivedBundle(*element), depth + 1, left, content);
        else
            takeMessage(element->Contents(), static_cast<std::size_t>(element->Size()), content);
    }
}

} // namespace

void requireOsc() {}

OscContent decodeOsc(const char* data, std::size_t size)
{
    if (size > kMostOscBytes)
        throw base::InputError(fmt::format("{} bytes, should be up to {}", size, kMostOscBytes));
    OscContent content;
    std::size_t left = kMostMessages;
    try
    {
        const osc::ReceivedPacket packet(data, size);
        if (packet.IsBundle())
            takeBundle(osc::ReceivedBundle(packet), 1, left, content);
        else
            takeMessage(data, size, content);
    }
    catch (const osc::Exception& error)
    {
        throw base::InputError(std::string("no OSC: ") + error.what());
    }
    return content;
}

std::size_t OscWriter::hands(const std::vector<Hand>& hands, double time_s)
{
    osc::OutboundPacketStream out(_bytes.data(), _bytes.size());
    out << osc::BeginBundleImmediate;
    std::array<bool, 2> isThere{};
    for (const Hand& hand : hands)
    {
        if (hand.id < 0 || hand.id > 1 || isThere[static_cast<std::size_t>(hand.id)]) continue;
        isThere[static_cast<std::size_t>(hand.id)] = true;
        out << osc::BeginMessage(kOscHand) << (hand.id == 0 ? "left" : "right") << time_s
            << static_cast<float>(std::clamp(hand.age_s, 0.0, kOldestOscHand_s));
        for (const HandJoint& joint : hand.joints)
        {
            const Eigen::Vector3f p = joint.position.cast<float>();
            const Eigen::Vector4f q = joint.orientation.coeffs().cast<float>();
            out << p.x() << p.y() << p.z() << q[0] << q[1] << q[2] << q[3]
                << static_cast<float>(joint.radius_m)
                << static_cast<osc::int32>((joint.positionValid ? kPositionValid : 0) |
                                           (joint.orientationValid ? kOrientationValid : 0));
        }
        out << osc::EndMessage;
    }
    out << osc::EndBundle;
    return out.Size();
}

std::size_t OscWriter::head(const Head& head)
{
    const Eigen::Vector3f p = head.pose.translation().cast<float>();
    const Eigen::Vector4f q = Eigen::Quaterniond(head.pose.linear()).coeffs().cast<float>();
    osc::OutboundPacketStream out(_bytes.data(), _bytes.size());
    out << osc::BeginMessage(kOscHead) << head.time_s
        << static_cast<float>(std::clamp(head.age_s, 0.0, kOldestOscHand_s)) << p.x() << p.y()
        << p.z() << q[0] << q[1] << q[2] << q[3] << osc::EndMessage;
    return out.Size();
}

std::size_t OscWriter::text(const std::string& text)
{
    osc::OutboundPacketStream out(_bytes.data(), _bytes.size());
    out << osc::BeginMessage(kOscText) << text.substr(0, kMostText).c_str() << osc::EndMessage;
    return out.Size();
}

std::size_t OscWriter::horizon(double ahead_s)
{
    osc::OutboundPacketStream out(_bytes.data(), _bytes.size());
    out << osc::BeginMessage(kOscHorizon) << static_cast<float>(ahead_s) << osc::EndMessage;
    return out.Size();
}

} // namespace midair::bridge
