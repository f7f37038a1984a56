#include "haptics/base/InputError.h"
#include "samples/experiments/coincide/CoincidenceStudy.h"
#include "tests/samples/Shell.h"

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

namespace
{

using namespace midair::samples;
using Eigen::Vector3d;

const Vector3d kInjected_m(0.003, -0.001, 0.006);

std::vector<Reach> session(std::uint64_t seed, int trials)
{
    const SimulatedReacher person{kInjected_m, 0.005, seed};
    std::vector<Reach> all;
    for (int k = 0; k < trials; ++k)
    {
        Reach trial = trialOf(k, seed, {0.0, 0.0, 0.1}, 0.02);
        trial.tip = person.tip(k, trial);
        all.push_back(trial);
    }
    return all;
}

std::string fresh(const std::string& name)
{
    const std::string path =
        testing::TempDir() + "midair-coincide-" + std::to_string(::getpid()) + "-" + name;
    std::remove(path.c_str());
    return path;
}

} // namespace

// Over 200 sessions: the mean of what is found, and how often two standard errors cover the truth.
TEST(Coincide, ASimulatedParticipantRecoversTheInjectedOffset)
{
    Vector3d sum = Vector3d::Zero();
    int covered = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed)
    {
        const Coincidence found = coincidenceOf(session(seed, 24));
        EXPECT_EQ(found.seen, 12);
        EXPECT_EQ(found.felt, 12);
        sum += found.difference;
        for (int axis = 0; axis < 3; ++axis)
        {
            const double off = std::abs(found.difference[axis] - kInjected_m[axis]);
            covered += off <= 2.0 * found.standardError[axis] ? 1 : 0;
        }
    }
    // 5 mm sqrt(2/12) a session: 0.14 mm of the mean of 200.
    EXPECT_LT((sum / 200.0 - kInjected_m).cwiseAbs().maxCoeff(), 0.5e-3);
    // Student's t with 22 degrees of freedom: 94 % within 2.
    EXPECT_NEAR(covered / 600.0, 0.94, 0.03);
}

TEST(Coincide, PairsAreOneSeenAndOneFeltInEitherOrder)
{
    int feltFirst = 0;
    for (int pair = 0; pair < 100; ++pair)
    {
        const Reach a = trialOf(2 * pair, 5, {0.0, 0.0, 0.1}, 0.02);
        const Reach b = trialOf(2 * pair + 1, 5, {0.0, 0.0, 0.1}, 0.02);
        EXPECT_NE(a.isFelt, b.isFelt);
        EXPECT_NE(a.place, b.place);
        EXPECT_LE((a.place - Vector3d(0.0, 0.0, 0.1)).cwiseAbs().maxCoeff(), 0.02);
        feltFirst += a.isFelt ? 1 : 0;
    }
    EXPECT_GT(feltFirst, 30);
    EXPECT_LT(feltFirst, 70);
}

TEST(Coincide, AFileGoesOnWhereItWasAndKeepsAnotherSession)
{
    const std::string path = fresh("log.csv");
    const std::vector<Reach> trials = session(2, 6);
    {
        ReachLog log(path, "one");
        for (const Reach& trial : trials)
            log.add(trial);
    }
    {
        std::ofstream torn(path, std::ios::app);
        torn << "7,seen,0.1";
    }
    {
        const ReachLog log(path, "one");
        ASSERT_EQ(log.reaches().size(), 6U);
        EXPECT_LT((log.reaches()[3].tip - trials[3].tip).norm(), 2e-6);
        EXPECT_EQ(log.reaches()[3].isFelt, trials[3].isFelt);
    }
    EXPECT_THROW(ReachLog(path, "another"), midair::base::InputError);
}

TEST(Coincide, TheProgramPrintsTheDifferenceWithItsStandardError)
{
    const std::string path = fresh("program.csv");
    const std::string command =
        MIDAIR_BIN
        "/midair-coincide --headless --pictures 0 --participant P01 --simulate --pairs 8 --minutes "
        "3 --offset 0.01 0 -0.02 --noise 0.001 --results " +
        path;
    const Outcome outcome = shell("cd " + testing::TempDir() + " && " + command);
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("8 seen and 8 felt trials\n"), std::string::npos)
        << outcome.output;
    EXPECT_NE(outcome.output.find(", x: +"), std::string::npos) << outcome.output;
    const ReachLog log(path,
                       [&]
                       {
                           std::ifstream in(path);
                           std::string line;
                           std::getline(in, line);
                           std::getline(in, line);
                           return line.substr(2);
                       }());
    const Coincidence found = coincidenceOf(log.reaches());
    EXPECT_NEAR(found.difference.x(), 0.01, 2e-3);
    EXPECT_NEAR(found.difference.z(), -0.02, 2e-3);
    EXPECT_NEAR(found.standardError.x(), 0.5e-3, 0.35e-3);
}
