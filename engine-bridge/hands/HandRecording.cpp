#include "engine-bridge/hands/HandRecording.h"

#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace midair::bridge
{

const char* const kRecordedHeadings =
    "time_s,hand,joint,x,y,z,qx,qy,qz,qw,radius_m,position_valid,orientation_valid";

namespace
{

constexpr std::size_t kMostBytes = std::size_t(64) << 20;
constexpr double kFarthest_m = 1e6;
constexpr double kLargestRadius_m = 1e3;
constexpr double kLongest_s = 1e9;
constexpr std::size_t kColumns = 13;

/// Joint names in files have underscores instead of blanks.
std::string fileName(int joint)
{
    std::string name = jointName(joint);
    std::replace(name.begin(), name.end(), ' ', '_');
    return name;
}

int jointNumber(const std::string& name)
{
    if (name == "head") return RecordedRow::kHead;
    for (int joint = 0; joint < HAND_JOINTS; ++joint)
        if (name == fileName(joint)) return joint;
    return -1;
}

/// Fills \a row and returns "", or returns the error of the line.
std::string parseRow(const std::vector<std::string>& fields, RecordedRow& row)
{
    if (fields.size() != kColumns)
        return fmt::format("{} columns; a joint has 13: {}", fields.size(), kRecordedHeadings);
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

} // namespace

void readRecording(std::istream& in,
                   const std::string& name,
                   const std::function<std::string(const RecordedRow& row)>& take)
{
    std::string line;
    for (int number = 1; std::getline(in, line); ++number)
    {
        const std::vector<std::string> fields = base::splitColumns(line);
        if (fields.empty() || fields[0] == "time_s") continue;
        RecordedRow row;
        std::string wrong = parseRow(fields, row);
        if (wrong.empty()) wrong = take(row);
        if (!wrong.empty())
            throw base::InputError(fmt::format("{}, line {}: {}", name, number, wrong));
    }
}

std::string recordingIn(const std::string& path)
{
    return base::readRegularFile(path, kMostBytes, "hand recording \"" + path + "\" ");
}

double recordedTime(double time_s, double duration_s, bool loops)
{
    if (!loops || !(duration_s > 0.0)) return time_s;
    const double t = std::fmod(time_s, duration_s);
    return t < 0.0 ? t + duration_s : t;
}

} // namespace midair::bridge
