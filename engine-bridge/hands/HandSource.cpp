#include "engine-bridge/hands/HandSource.h"

#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <cmath>
#include <istream>
#include <sstream>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

// A line of 30 bytes makes a hand of 2,000 bytes, so a limit on the size of the file is not enough.
constexpr std::size_t kMostBytes = std::size_t(64) << 20;
constexpr std::size_t kMostFrames = 200000;
constexpr std::size_t kMostHandsInAll = 200000;
constexpr std::size_t kMostHandsInFrame = 8;
constexpr double kFarthest_m = 1e6;
constexpr double kLargestRadius_m = 1e3;
constexpr double kLongest_s = 1e9;
constexpr std::size_t kColumns = 13;
const char* const kHeadings =
    "time_s,hand,joint,x,y,z,qx,qy,qz,qw,radius_m,position_valid,orientation_valid";

/// Joint names in files have underscores instead of blanks.
std::string fileName(int joint)
{
    std::string name = jointName(joint);
    std::replace(name.begin(), name.end(), ' ', '_');
    return name;
}

int jointNumber(const std::string& name)
{
    for (int joint = 0; joint < HAND_JOINTS; ++joint)
        if (name == fileName(joint)) return joint;
    return -1;
}

/// One line of a recording: one joint.
struct Row
{
    double time_s = 0.0;
    int hand = 0;
    int joint = 0;
    HandJoint value;
};

/// Fills \a row and returns "", or returns what is wrong with the line.
std::string parse(const std::vector<std::string>& fields, Row& row)
{
    if (fields.size() != kColumns)
        return fmt::format("{} columns; a joint has 13: {}", fields.size(), kHeadings);
    row.joint = jointNumber(fields[2]);
    if (row.joint < 0) return "joint \"" + fields[2] + "\" is not known; index_tip is one";
    std::array<double, kColumns> numbers{};
    for (std::size_t i = 0; i < kColumns; ++i)
        if (i != 2 && !base::parseNumber(fields[i], numbers[i]))
            return fmt::format("\"{}\" in column {} is not a finite number", fields[i], i + 1);
    if (numbers[1] != std::floor(numbers[1]) || std::abs(numbers[1]) > 1e6)
        return "hand \"" + fields[1] +
               "\" is not a whole number; 0 is the left one, 1 the right one";
    row.time_s = numbers[0];
    row.hand = static_cast<int>(numbers[1]);
    HandJoint& joint = row.value;
    joint.position = Eigen::Vector3d(numbers[3], numbers[4], numbers[5]);
    joint.orientation = Eigen::Quaterniond(numbers[9], numbers[6], numbers[7], numbers[8]);
    joint.radius_m = numbers[10];
    joint.positionValid = numbers[11] != 0.0;
    joint.orientationValid = numbers[12] != 0.0;
    if (row.time_s < 0.0) return "time " + fields[0] + " is before 0";
    if (row.time_s > kLongest_s) return "time " + fields[0] + " is over 1e9 s";
    if (!(joint.position.cwiseAbs().maxCoeff() <= kFarthest_m))
        return "the joint is farther than 1e6 m from the origin";
    if (joint.radius_m < 0.0) return "radius " + fields[10] + " is under 0";
    if (joint.radius_m > kLargestRadius_m) return "radius " + fields[10] + " is over 1000 m";
    if (joint.orientationValid && std::abs(joint.orientation.norm() - 1.0) > 1e-3)
        return "the quaternion's length is not 1";
    if (joint.orientationValid) joint.orientation.normalize();
    return {};
}

/// The frame's hand with that id, or null.
Hand* handOf(HandFrame& frame, int id)
{
    for (Hand& hand : frame.hands)
        if (hand.id == id) return &hand;
    return nullptr;
}

/// Interpolates a joint; it is valid if it is valid in both frames.
HandJoint between(const HandJoint& a, const HandJoint& b, double share)
{
    HandJoint joint;
    joint.positionValid = a.positionValid && b.positionValid;
    joint.orientationValid = a.orientationValid && b.orientationValid;
    joint.position = (1.0 - share) * a.position + share * b.position;
    if (joint.orientationValid) joint.orientation = a.orientation.slerp(share, b.orientation);
    joint.radius_m = (1.0 - share) * a.radius_m + share * b.radius_m;
    return joint;
}

HandFrame between(const HandFrame& a, const HandFrame& b, double share)
{
    HandFrame frame;
    for (const Hand& before : a.hands)
        for (const Hand& after : b.hands)
        {
            if (before.id != after.id) continue;
            Hand hand;
            hand.id = before.id;
            for (std::size_t i = 0; i < HAND_JOINTS; ++i)
                hand.joints[i] = between(before.joints[i], after.joints[i], share);
            frame.hands.push_back(hand);
        }
    return frame;
}

} // namespace

RecordedHandSource::RecordedHandSource(const std::string& path, bool loop) :
    _name(path),
    _loop(loop)
{
    std::istringstream in(
        base::readRegularFile(path, kMostBytes, "hand recording \"" + path + "\" "));
    read(in);
}

RecordedHandSource::RecordedHandSource(std::istream& in, const std::string& name, bool loop) :
    _name(name),
    _loop(loop)
{
    read(in);
}

void RecordedHandSource::read(std::istream& in)
{
    std::string line;
    Row row;
    std::size_t hands = 0;
    for (int number = 1; std::getline(in, line); ++number)
    {
        const std::vector<std::string> fields = base::splitColumns(line);
        if (fields.empty() || fields[0] == "time_s") continue;
        std::string wrong = parse(fields, row);
        if (wrong.empty() && !_frames.empty() && row.time_s < _frames.back().time_s)
            wrong = "time " + fields[0] + " is before the line above it";
        const bool isNew = _frames.empty() || row.time_s > _frames.back().time_s;
        Hand* hand = isNew ? nullptr : handOf(_frames.back(), row.hand);
        if (wrong.empty() && isNew && _frames.size() == kMostFrames)
            wrong = "more than 200000 frames, which are the most possible";
        if (wrong.empty() && !hand && !isNew && _frames.back().hands.size() == kMostHandsInFrame)
            wrong = "more than 8 hands at one time, which are the most possible";
        if (wrong.empty() && !hand && hands == kMostHandsInAll)
            wrong = "more than 200000 hands in all frames together, which are the most possible";
        if (!wrong.empty())
            throw base::InputError(fmt::format("{}, line {}: {}", _name, number, wrong));
        if (isNew)
        {
            _frames.emplace_back();
            _frames.back().time_s = row.time_s;
        }
        if (!hand)
        {
            hand = &_frames.back().hands.emplace_back();
            hand->id = row.hand;
            ++hands;
        }
        hand->joints[static_cast<std::size_t>(row.joint)] = row.value;
    }
    if (_frames.empty())
        throw base::InputError(_name + ": no hand joints in it; a line is " + kHeadings);
}

double RecordedHandSource::duration_s() const
{
    return _frames.back().time_s;
}

bool RecordedHandSource::frameAt(double time_s, HandFrame& frame)
{
    double t = time_s;
    if (_loop && duration_s() > 0.0)
    {
        t = std::fmod(t, duration_s());
        if (t < 0.0) t += duration_s();
    }
    const auto after =
        std::lower_bound(_frames.begin(),
                         _frames.end(),
                         t,
                         [](const HandFrame& f, double value) { return f.time_s < value; });
    if (after != _frames.end() && after->time_s == t)
        frame = *after;
    else if (after == _frames.begin() || after == _frames.end())
        frame.hands.clear();
    else
    {
        const HandFrame& before = *(after - 1);
        const double gap = after->time_s - before.time_s;
        if (gap > kLongestGap_s)
            frame.hands.clear();
        else
            frame = between(before, *after, (t - before.time_s) / gap);
    }
    frame.time_s = time_s;
    return !frame.hands.empty();
}

std::string RecordedHandSource::status() const
{
    return fmt::format("{}: {} recorded frames", _name, _frames.size());
}

void InjectedHandSource::set(const HandFrame& frame)
{
    const base::Lock lock(_mutex);
    _frame = frame;
    ++_set;
}

void InjectedHandSource::clear()
{
    const base::Lock lock(_mutex);
    _frame.hands.clear();
}

bool InjectedHandSource::frameAt(double time_s, HandFrame& frame)
{
    const base::Lock lock(_mutex);
    frame.time_s = time_s;
    frame.hands.clear();
    if (_frame.hands.empty() || !(std::abs(time_s - _frame.time_s) <= _staleAfter_s)) return false;
    frame = _frame;
    return true;
}

std::string InjectedHandSource::status() const
{
    const base::Lock lock(_mutex);
    return fmt::format("hands set by the application, {} frames so far", _set);
}

} // namespace midair::bridge
