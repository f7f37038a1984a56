// What a field of the C interface tells: levels, pressures, figures, and that it outlives its
// scene.
#include "haptics/probe/Feeling.h"
#include "tests/engine-bridge/c/Star.h"

#include <atomic>
#include <cmath>
#include <complex>
#include <fstream>
#include <thread>

TEST(CField, PressureIsTheSumOverTransducers)
{
    // On the axis of one transducer: P0/R e^{-beta R} e^{-jkR}. At 40 kHz, 20 C and 50 % humidity
    // ISO 9613-1 has beta = 0.152 Np/m (1.32 dB/m).
    midair_transducer one{};
    one.normal[2] = 2.0; // of any length
    one.gain = 1.0;
    midair_array* array = nullptr;
    ASSERT_EQ(midair_array_make("one", &one, 1, 40e3, 10.0, &array), MIDAIR_OK)
        << midair_last_error();
    midair_scene* scene = nullptr;
    ASSERT_EQ(midair_scene_make(array, &scene), MIDAIR_OK);
    const double place[] = {0.0, 0.0, 0.2};
    midair_object points = 0;
    ASSERT_EQ(midair_add_points(scene, place, nullptr, 1, 0, &points), MIDAIR_OK);
    {
        const Solved solved(scene);
        ASSERT_EQ(solved.status, MIDAIR_OK) << solved.why;
        const std::vector<float> q = solved.activations();
        const std::complex<double> drive(static_cast<double>(q[0]), static_cast<double>(q[1]));
        EXPECT_NEAR(std::abs(drive), 1.0, 1e-3);
        float p[2];
        ASSERT_EQ(midair_field_pressures(solved.field, 0, place, 1, p), MIDAIR_OK);
        const std::complex<double> heard(static_cast<double>(p[0]), static_cast<double>(p[1]));
        EXPECT_NEAR(std::abs(heard), 10.0 / 0.2 * std::exp(-0.152 * 0.2), 0.1);
        const double wavelength_m = 343.2 / 40e3; // 20 C
        const std::complex<double> turned = heard / drive;
        const double phase =
            std::remainder(std::arg(turned) + 2 * M_PI * 0.2 / wavelength_m, 2 * M_PI);
        EXPECT_NEAR(phase, 0.0, 0.1);
        float felt = 0.0F;
        ASSERT_EQ(midair_field_felt(solved.field, place, 1, &felt), MIDAIR_OK);
        EXPECT_NEAR(static_cast<double>(felt), std::abs(heard), 1e-3);
    }
    midair_scene_close(scene);
    midair_array_close(array);
}

// 0.04 mm, as a model in other units has, is one focus; with all of the sound it would have 40 kPa.
TEST(CField, WhatIsOneFocusIsAskedAboutAndNoLouderThanAPointOfTheWhole)
{
    const std::string star = std::string(MIDAIR_ROOT) + "/samples/models/star.obj";
    double whole_Pa = 0.0;
    for (const double size_m : {0.1, 4e-5})
    {
        Opened of;
        midair_object object = 0;
        ASSERT_EQ(midair_add_file(of.scene, star.c_str(), size_m, &object), MIDAIR_OK);
        const Solved solved(of.scene);
        ASSERT_EQ(solved.status, MIDAIR_OK) << solved.why;
        const double level_Pa = solved.figure("level_Pa");
        const bool isAsked = of.messages().find("under half a wavelength") != std::string::npos;
        EXPECT_EQ(isAsked, size_m < 0.01) << of.messages();
        if (size_m > 0.01) whole_Pa = level_Pa;
        EXPECT_GT(level_Pa, 100.0);
        EXPECT_LE(level_Pa, whole_Pa);
    }
}

TEST(CField, WhatOfAFileCantBeFeltIsTold)
{
    const std::string file = testing::TempDir() + "midair-c-corners.obj";
    std::ofstream(file) << "v 0 0 0\nv 0.04 0 0\nv 0 0.04 0\nf 1 2\nf 1 2 3\n";
    Opened of;
    midair_object object = 0;
    ASSERT_EQ(midair_add_file(of.scene, file.c_str(), 0.0, &object), MIDAIR_OK);
    EXPECT_NE(of.messages().find(file + ", line 4: the face has 2 corners"), std::string::npos)
        << of.messages();
}

TEST(CField, LevelsAndViewAreTheActivations)
{
    Opened of;
    addStar(of.scene);
    const Solved solved(of.scene);
    ASSERT_EQ(solved.status, MIDAIR_OK);
    const std::vector<float> q = solved.activations();
    std::vector<int32_t> phases(solved.info.transducers);
    std::vector<int32_t> amplitudes(solved.info.transducers);
    ASSERT_EQ(midair_field_levels(
                  solved.field, 0, phases.data(), amplitudes.data(), solved.info.transducers),
              MIDAIR_OK);
    const float* view = nullptr;
    ASSERT_EQ(midair_field_view(solved.field, 0, &view), MIDAIR_OK);
    double worst = 0.0;
    for (std::size_t i = 0; i < phases.size(); ++i)
    {
        const std::complex<double> played(static_cast<double>(q[2 * i]),
                                          static_cast<double>(q[2 * i + 1]));
        worst = std::max(worst,
                         std::abs(played - std::polar(std::sin(M_PI * amplitudes[i] / 510.0),
                                                      2 * M_PI * phases[i] / 256.0)));
        ASSERT_EQ(view[2 * i], q[2 * i]);
    }
    EXPECT_LT(worst, 1e-6);
}

TEST(CField, OutlivesSceneAndArray)
{
    midair_field* field = nullptr;
    {
        Opened of;
        addStar(of.scene);
        ASSERT_EQ(midair_set(of.scene, "feelThreshold", "1 N"), MIDAIR_OK);
        ASSERT_EQ(midair_solve(of.scene, &field), MIDAIR_OK);
        char faint[32] = "";
        EXPECT_EQ(midair_field_text(field, "feeling", faint, sizeof(faint), nullptr), MIDAIR_OK);
        EXPECT_EQ(std::string(faint), "too weak to feel");
        EXPECT_EQ(midair_field_close(field), MIDAIR_OK);
        ASSERT_EQ(midair_set(of.scene, "feelThreshold", "0"), MIDAIR_OK);
        ASSERT_EQ(midair_solve(of.scene, &field), MIDAIR_OK);
    }
    double level_Pa = 0.0;
    EXPECT_EQ(midair_field_figure(field, "level_Pa", &level_Pa), MIDAIR_OK);
    EXPECT_GT(level_Pa, 100.0);
    double ears_dB = 0.0;
    EXPECT_EQ(midair_field_figure(field, "exposure.level_dB", &ears_dB), MIDAIR_OK);
    EXPECT_GT(ears_dB, 100.0);
    double force_N = 0.0;
    EXPECT_EQ(midair_field_figure(field, "fingertipForce_N", &force_N), MIDAIR_OK);
    EXPECT_GT(force_N, 1e-4);
    EXPECT_LT(force_N, 1.0);
    char feeling[32] = "";
    EXPECT_EQ(midair_field_text(field, "feeling", feeling, sizeof(feeling), nullptr), MIDAIR_OK);
    EXPECT_EQ(std::string(feeling),
              midair::haptics::strengthName(
                  midair::haptics::strengthOf(force_N, midair::haptics::PlayedAs::HELD)));
    EXPECT_EQ(midair_field_figure(field, "levelPa", &level_Pa), MIDAIR_UNKNOWN);
    EXPECT_NE(std::string(midair_last_error()).find("level_Pa"), std::string::npos);
    std::size_t figures = 0;
    const char* name = nullptr;
    double value = 0.0;
    while (midair_field_figure_at(field, figures, &name, &value) == MIDAIR_OK)
        ++figures;
    EXPECT_GT(figures, 25U);
    EXPECT_EQ(midair_field_close(field), MIDAIR_OK);
    EXPECT_EQ(midair_field_close(field), MIDAIR_CLOSED);
}

TEST(CField, CapsHold)
{
    Opened of;
    addStar(of.scene);
    ASSERT_EQ(midair_set(of.scene, "maxAmplitude", "0.3"), MIDAIR_OK);
    const Solved quiet(of.scene);
    ASSERT_EQ(quiet.status, MIDAIR_OK) << quiet.why;
    const std::vector<float> q = quiet.activations();
    for (std::size_t i = 0; i < q.size(); i += 2)
        ASSERT_LE(std::hypot(q[i], q[i + 1]), 0.3F + 1e-6F);
    ASSERT_EQ(midair_set(of.scene, "maxAmplitude", "1"), MIDAIR_OK);
    ASSERT_EQ(midair_set(of.scene, "maxPressure", "0.01 Pa"), MIDAIR_OK);
    const Solved silent(of.scene);
    EXPECT_EQ(silent.status, MIDAIR_SILENT);
    EXPECT_NE(silent.why.find("maxPressure"), std::string::npos) << silent.why;
    for (const float part : silent.activations())
        ASSERT_EQ(part, 0.0F);
    midair_solver* solver = nullptr;
    EXPECT_EQ(midair_solver_open(of.scene, &solver), MIDAIR_REFUSED) << "it keeps no caps";
    EXPECT_EQ(solver, nullptr);
}

TEST(CField, FiguresOfTheExposureAreEachFieldsOwn)
{
    Opened octagon;
    Opened board("board");
    addStar(octagon.scene);
    const double place[] = {0.0, 0.0, 0.15};
    midair_object points = 0;
    ASSERT_EQ(midair_add_points(board.scene, place, nullptr, 1, 0, &points), MIDAIR_OK);
    std::vector<std::vector<double>> levels_dB;
    for (int round = 0; round < 2; ++round)
    {
        std::vector<double>& now = levels_dB.emplace_back();
        for (const char* celsius : {"20", "35"})
            for (const char* ears : {"", "0 0 0.7"})
                for (midair_scene* scene : {octagon.scene, board.scene})
                {
                    ASSERT_EQ(midair_set(scene, "temperature", celsius), MIDAIR_OK);
                    ASSERT_EQ(midair_set(scene, "earPoints", ears), MIDAIR_OK);
                    const Solved solved(scene);
                    ASSERT_EQ(solved.status, MIDAIR_OK) << solved.why;
                    now.push_back(solved.figure("exposure.level_dB"));
                    now.push_back(solved.figure("exposure.places"));
                }
    }
    EXPECT_EQ(levels_dB[0], levels_dB[1]);
    EXPECT_NE(levels_dB[0][0], levels_dB[0][2]) << "another array";
    EXPECT_NE(levels_dB[0][0], levels_dB[0][8]) << "another air";
    EXPECT_EQ(levels_dB[0][1] + 1.0, levels_dB[0][5]) << "another ear";
}

TEST(CThreads, SolveOneSceneTogetherAndOneCancels)
{
    Opened of("board");
    double positions[] = {0.0, 0.0, 0.15, 0.02, 0.0, 0.15};
    midair_object points = 0;
    ASSERT_EQ(midair_add_points(of.scene, positions, nullptr, 2, 0, &points), MIDAIR_OK);
    std::atomic<int> wrong{0};
    std::vector<std::thread> threads;
    for (int t = 0; t < 3; ++t)
        threads.emplace_back(
            [&, t]
            {
                for (int k = 0; k < 6; ++k)
                {
                    const std::string celsius = std::to_string(15 + (t + k) % 10);
                    if (midair_set(of.scene, "temperature", celsius.c_str()) != MIDAIR_OK) ++wrong;
                    midair_field* field = nullptr;
                    const midair_status status = midair_solve(of.scene, &field);
                    if (status != MIDAIR_OK && status != MIDAIR_STOPPED) ++wrong;
                    if (field && midair_field_close(field) != MIDAIR_OK) ++wrong;
                    if (t == 0 && midair_cancel(of.scene) != MIDAIR_OK) ++wrong;
                }
            });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(wrong, 0);
}

// The scene is closed while others use it: each call ends with a status.
TEST(CThreads, ACloseWhileOthersCallIsAnErrorForThem)
{
    for (int round = 0; round < 4; ++round)
    {
        midair_array* array = nullptr;
        midair_scene* scene = nullptr;
        ASSERT_EQ(midair_array_load("board", &array), MIDAIR_OK);
        ASSERT_EQ(midair_scene_make(array, &scene), MIDAIR_OK);
        const double place[] = {0.0, 0.0, 0.15};
        midair_object points = 0;
        ASSERT_EQ(midair_add_points(scene, place, nullptr, 1, 0, &points), MIDAIR_OK);
        ASSERT_EQ(midair_play(scene, "sim:"), MIDAIR_OK);
        std::atomic<int> closed{0};
        std::vector<std::thread> threads;
        for (int t = 0; t < 2; ++t)
            threads.emplace_back(
                [&]
                {
                    for (int k = 0; k < 200000; ++k)
                    {
                        const midair_status status = midair_set_pose(scene, points, kIdentity);
                        midair_state(scene, nullptr);
                        if (status == MIDAIR_CLOSED)
                        {
                            ++closed;
                            return;
                        }
                    }
                });
        EXPECT_EQ(midair_scene_close(scene), MIDAIR_OK);
        for (std::thread& thread : threads)
            thread.join();
        EXPECT_EQ(closed, 2);
        midair_array_close(array);
    }
}

TEST(CField, TransducersThatASettingNamesAreNotDriven)
{
    Opened of;
    addStar(of.scene);
    ASSERT_EQ(midair_set(of.scene, "dead", "17, 400-410"), MIDAIR_OK) << midair_last_error();
    {
        const Solved solved(of.scene);
        ASSERT_EQ(solved.status, MIDAIR_OK) << solved.why;
        const std::vector<float> q = solved.activations();
        int driven = 0;
        for (std::size_t i = 0; i < solved.info.transducers; ++i)
        {
            const bool isDead = i == 17 || (i >= 400 && i <= 410);
            const bool isDriven = q[2 * i] != 0.0F || q[2 * i + 1] != 0.0F;
            EXPECT_FALSE(isDead && isDriven) << i;
            driven += isDriven ? 1 : 0;
        }
        EXPECT_GT(driven, 3900);
    }
    for (const auto& [name, wrong] : {std::pair("dead", "9999"), {"dead", "x"}, {"weak", "1:5000"}})
    {
        ASSERT_EQ(midair_set(of.scene, name, wrong), MIDAIR_INVALID) << wrong;
        EXPECT_NE(std::string(midair_last_error()).find("; nothing is played"), std::string::npos)
            << midair_last_error();
        const Solved refused(of.scene);
        EXPECT_EQ(refused.status, MIDAIR_SILENCED) << wrong;
        EXPECT_NE(refused.why.find(wrong), std::string::npos) << refused.why;
        ASSERT_EQ(midair_set(of.scene, name, ""), MIDAIR_OK) << midair_last_error();
        EXPECT_EQ(Solved(of.scene).status, MIDAIR_OK) << "it is right again";
    }
}
