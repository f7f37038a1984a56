#include "tests/samples/installations/Run.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

TEST(Toybox, ToysArePushedAndFelt)
{
    const OwnFolder out("toybox");
    const Visit run = visit("toybox", "--frames 420", out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    expectQuiet(run.report);
    EXPECT_EQ(run.report.at("array"), "octagon");
    EXPECT_EQ(run.report.at("transducers"), 3984);
    int pushed = 0;
    double way_mm = 0.0;
    double force_mN = 0.0;
    for (const auto& toy : run.report.at("scene").at("toys"))
    {
        if (toy.at("pushes") > 0 && toy.at("touches") > 0) ++pushed;
        way_mm += toy.at("pushedWay_mm").get<double>();
        force_mN = std::max(force_mN, toy.at("largestForce_mN").get<double>());
    }
    EXPECT_GE(pushed, 3) << run.report.at("scene");
    EXPECT_GT(way_mm, 100.0);
    EXPECT_GT(force_mN, 1.0);
    EXPECT_GT(run.report.at("contactFields"), 0);
    EXPECT_GT(run.report.at("fields").at("played"), 0);
    EXPECT_EQ(run.report.at("scene").at("broughtBack"), 0); // none leaves the box
}

TEST(Toybox, ToysRepeatWithTheirSeed)
{
    const auto ways = [](const std::string& seed)
    {
        const OwnFolder out("toybox_" + seed);
        const Visit run = visit("toybox", "--frames 150 --device null: --seed " + seed, out);
        std::vector<double> way_mm;
        if (run.report.contains("scene"))
            for (const auto& toy : run.report.at("scene").at("toys"))
                way_mm.push_back(toy.at("pushedWay_mm"));
        return way_mm;
    };
    const std::vector<double> first = ways("1");
    ASSERT_EQ(first.size(), 5U);
    EXPECT_GT(*std::max_element(first.begin(), first.end()), 0.0);
    EXPECT_EQ(first, ways("1"));
    EXPECT_NE(first, ways("2"));
}
