// An application's own devices, solvers and hands.
#include "tests/Halt.h"
#include "tests/engine-bridge/c/Played.h"

#include <atomic>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <thread>

namespace
{

/// An own device and what was asked of it.
struct Desk
{
    std::atomic<int> plays{0};
    std::atomic<int> silences{0};
    std::atomic<int> closed{0};
    std::atomic<bool> throws{false};
    std::string path;
    std::string options;
    uint32_t transducers = 0;
    midair_status inside = MIDAIR_OK;
    midair_scene* scene = nullptr;
};

void* openDesk(void* user,
               const char* path,
               const char* options,
               const int32_t*,
               uint32_t transducers,
               char* error,
               size_t size)
{
    auto& desk = *static_cast<Desk*>(user);
    if (std::strcmp(path, "shut") == 0)
    {
        std::snprintf(error, size, "the desk is shut");
        return nullptr;
    }
    desk.path = path;
    desk.options = options;
    desk.transducers = transducers;
    return user;
}

int32_t playDesk(void* instance, const uint8_t*, const uint8_t* amplitudes)
{
    auto& desk = *static_cast<Desk*>(instance);
    if (desk.throws) throw std::runtime_error("a C++ callback");
    if (desk.scene) desk.inside = midair_set(desk.scene, "cycle", "2");
    for (uint32_t i = 0; i < desk.transducers; ++i)
        if (amplitudes[i] > 1) return 1;
    ++desk.plays;
    return 0;
}

int32_t silenceDesk(void* instance)
{
    ++static_cast<Desk*>(instance)->silences;
    return 0;
}

void closeDesk(void* instance)
{
    ++static_cast<Desk*>(instance)->closed;
}

Desk& theDesk()
{
    static Desk desk;
    return desk;
}

midair_driver deskDriver()
{
    static const float onOff[] = {0.0F, 1.0F};
    midair_driver driver{};
    driver.struct_size = sizeof driver;
    driver.user = &theDesk();
    driver.open = openDesk;
    driver.play = playDesk;
    driver.silence = silenceDesk;
    driver.close = closeDesk;
    driver.phase_levels = 16;
    driver.amplitudes = onOff;
    driver.amplitude_count = 2;
    return driver;
}

int32_t backPropagate(
    void* user, const midair_problem* problem, float* activations, char* error, size_t size)
{
    const int mode = *static_cast<int*>(user);
    if (mode == 1)
    {
        std::snprintf(error, size, "not today");
        return 1;
    }
    if (mode == 2) activations[0] = NAN;
    if (mode == 3) throw std::runtime_error("thrown by a solver");
    if (mode == 2) return 0;
    for (uint32_t i = 0; i < problem->transducers; ++i)
    {
        const float real = problem->matrix[2 * i];
        const float imaginary = problem->matrix[2 * i + 1];
        const float length = std::hypot(real, imaginary);
        if (length <= 0.0F) continue;
        activations[2 * i] = real / length;
        activations[2 * i + 1] = -imaginary / length;
    }
    return problem->is_stopped(problem);
}

void* openStill(void* user, const char* options, char* error, size_t size)
{
    if (std::strcmp(options, "none") == 0)
    {
        std::snprintf(error, size, "no hands there");
        return nullptr;
    }
    return user;
}

int32_t stillHands(void* instance, double, midair_hand* hands, size_t capacity)
{
    int& mode = *static_cast<int*>(instance);
    if (mode == 1) return static_cast<int32_t>(capacity) + 1;
    if (mode == 2) throw std::runtime_error("a tracker");
    const double tip[] = {0.0, 0.0, 0.151};
    const double turn[] = {0.0, 0.0, 0.0, 1.0};
    midair_make_hand(0, tip, turn, hands);
    if (mode == 3) hands->joints[3].position[1] = INFINITY;
    return 1;
}

/// A tracker whose driver hangs once it is told to.
struct Tracker
{
    Halt halt;
    std::atomic<bool> isAsked{false};
};

void* openTracker(void* user, const char*, char*, size_t)
{
    return user;
}

int32_t hangingHands(void* instance, double, midair_hand*, size_t)
{
    auto& tracker = *static_cast<Tracker*>(instance);
    tracker.isAsked = true;
    tracker.halt.pass();
    return 0;
}

} // namespace

TEST(CExtend, AMuteAndAStopSilenceWhileAHandSourceHangs)
{
    const midair_driver driver = deskDriver();
    ASSERT_EQ(midair_register_device("table", &driver), MIDAIR_OK) << midair_last_error();
    Tracker tracker;
    midair_hand_source source{};
    source.struct_size = sizeof source;
    source.user = &tracker;
    source.open = openTracker;
    source.hands = hangingHands;
    ASSERT_EQ(midair_register_hands("hanging", &source), MIDAIR_OK) << midair_last_error();
    Desk& desk = theDesk();
    for (const bool isStop : {false, true})
    {
        Focus of;
        ASSERT_EQ(midair_play(of.scene, "table:"), MIDAIR_OK) << midair_last_error();
        ASSERT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING)) << of.messages();
        ASSERT_EQ(midair_open_hands(of.scene, "hanging:"), MIDAIR_OK) << midair_last_error();
        tracker.halt = true;
        tracker.isAsked = false;
        std::thread frame([&] { midair_update(of.scene, 1e6); });
        ASSERT_TRUE(eventually([&] { return tracker.isAsked.load(); }));
        const int silences = desk.silences;
        std::atomic<bool> isDone{false};
        std::thread other(
            [&]
            {
                isStop ? midair_stop(of.scene) : midair_mute(of.scene, 1);
                isDone = true;
            });
        EXPECT_TRUE(eventually([&] { return desk.silences > silences; }, 30.0)) << isStop;
        EXPECT_TRUE(isStop || eventually([&] { return isDone.load(); }, 20.0))
            << "it waits for nobody";
        tracker.halt = false;
        other.join();
        frame.join();
    }
}

TEST(CExtend, AnOwnDevicePlaysInItsLevels)
{
    const midair_driver driver = deskDriver();
    ASSERT_EQ(midair_register_device("desk", &driver), MIDAIR_OK) << midair_last_error();
    EXPECT_EQ(midair_register_device("desk", &driver), MIDAIR_REFUSED) << "taken";
    EXPECT_EQ(midair_register_device("sim", &driver), MIDAIR_REFUSED) << "the library's";
    EXPECT_EQ(midair_register_device("No Name", &driver), MIDAIR_REFUSED);
    midair_driver wrong = driver;
    wrong.struct_size = 8;
    EXPECT_EQ(midair_register_device("wrong", &wrong), MIDAIR_INVALID);
    wrong = driver;
    wrong.play = nullptr;
    EXPECT_EQ(midair_register_device("wrong", &wrong), MIDAIR_INVALID);
    wrong = driver;
    wrong.fields_per_second = NAN;
    EXPECT_EQ(midair_register_device("wrong", &wrong), MIDAIR_INVALID);
    Desk& desk = theDesk();
    {
        Focus of;
        desk.scene = of.scene;
        ASSERT_EQ(midair_play(of.scene, "desk:room 3?lamp=on&ramp=10ms"), MIDAIR_OK);
        ASSERT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING)) << of.messages();
        ASSERT_TRUE(updatesUntil(of.scene, [&] { return desk.plays > 0; }));
        EXPECT_EQ(desk.path, "room 3");
        EXPECT_EQ(desk.options, "lamp=on\n") << "the limits are the library's";
        EXPECT_EQ(desk.transducers, 249U);
        EXPECT_EQ(desk.inside, MIDAIR_INVALID) << "a callback may not call its scene";
        desk.throws = true;
        double moved[16];
        std::copy_n(kIdentity, 16, moved);
        moved[3] = 0.01;
        ASSERT_EQ(midair_set_pose(of.scene, of.points, moved), MIDAIR_OK);
        midair_device_state state{};
        EXPECT_TRUE(updatesUntil(of.scene,
                                 [&]
                                 {
                                     midair_state(of.scene, &state);
                                     return state.faults > 0;
                                 }));
        desk.throws = false;
    }
    desk.scene = nullptr;
    EXPECT_GT(desk.silences, 0);
    EXPECT_EQ(desk.closed, 1);
    Focus of;
    ASSERT_EQ(midair_play(of.scene, "desk:shut"), MIDAIR_OK);
    EXPECT_TRUE(updatesUntil(
        of.scene, [&] { return of.messages().find("the desk is shut") != std::string::npos; }))
        << of.messages();
}

TEST(CExtend, AnOwnSolverIsCheckedAndMeasured)
{
    static int mode = 0;
    ASSERT_EQ(midair_register_solver("back", backPropagate, &mode), MIDAIR_OK)
        << midair_last_error();
    EXPECT_EQ(midair_register_solver("back", backPropagate, &mode), MIDAIR_REFUSED);
    EXPECT_EQ(midair_register_solver("gs", backPropagate, &mode), MIDAIR_REFUSED);
    Focus of;
    ASSERT_EQ(midair_set(of.scene, "solver", "back"), MIDAIR_OK);
    {
        const Solved solved(of.scene);
        ASSERT_EQ(solved.status, MIDAIR_OK) << solved.why;
        EXPECT_GT(solved.figure("level_Pa"), 500.0);
        EXPECT_NEAR(solved.figure("loudness"), 1.0, 0.01) << "all waves in phase";
        char name[16];
        EXPECT_EQ(midair_field_text(solved.field, "solver", name, sizeof name, nullptr), MIDAIR_OK);
        EXPECT_STREQ(name, "back");
    }
    mode = 1;
    const std::pair<int, const char*> failures[] = {
        {1, "solver \"back\" has failed: not today"},
        {2, "solver \"back\" has failed: its activation 0 is nan+0i"},
        {3, "solver \"back\" has failed: it has thrown \"thrown by a solver\""}};
    for (const auto& [failure, why] : failures)
    {
        mode = failure;
        const Solved failed(of.scene);
        EXPECT_EQ(failed.status, MIDAIR_FAILED) << why;
        EXPECT_EQ(failed.field, nullptr) << why;
        EXPECT_EQ(failed.why.rfind(why, 0), 0U) << failed.why;
    }
    mode = 0;
    ASSERT_EQ(midair_set(of.scene, "solver", "nosuch"), MIDAIR_OK) << "known when it is made";
    const Solved unknown(of.scene);
    EXPECT_EQ(unknown.status, MIDAIR_REFUSED);
    EXPECT_NE(unknown.why.find("back"), std::string::npos) << unknown.why;
}

// An own solver that fails is an error in fields in turn and in a midair_solver, too.
TEST(CExtend, AnOwnSolverThatFailsIsAnErrorEverywhere)
{
    static int mode = 0;
    ASSERT_EQ(midair_register_solver("fails", backPropagate, &mode), MIDAIR_OK);
    Focus of;
    ASSERT_EQ(midair_set(of.scene, "solver", "fails"), MIDAIR_OK);
    midair_solver* solver = nullptr;
    ASSERT_EQ(midair_solver_open(of.scene, &solver), MIDAIR_OK) << midair_last_error();
    const double place[] = {0.0, 0.0, 0.15};
    const double target = 1.0;
    std::vector<float> q(2 * 249, 7.0F);
    mode = 3;
    EXPECT_EQ(midair_solver_solve(solver, place, &target, 1, 0, q.data(), 249), MIDAIR_FAILED);
    EXPECT_NE(std::string(midair_last_error()).find("thrown by a solver"), std::string::npos);
    EXPECT_EQ(q, std::vector<float>(2 * 249, 7.0F)) << "with an error nothing is written";
    double rms = 0.0;
    EXPECT_EQ(midair_solver_figure(solver, "rms", &rms), MIDAIR_NOT_YET);
    mode = 0;
    EXPECT_EQ(midair_solver_solve(solver, place, &target, 1, 0, q.data(), 249), MIDAIR_OK);
    EXPECT_EQ(midair_solver_close(solver), MIDAIR_OK);

    mode = 1;
    const double vertices[] = {-0.02, -0.02, 0.15, 0.02, -0.02, 0.15, 0.0, 0.02, 0.15};
    const uint32_t corners[] = {0, 1, 2};
    midair_object mesh = 0;
    ASSERT_EQ(midair_add_mesh(of.scene, vertices, 3, corners, 1, nullptr, &mesh), MIDAIR_OK);
    ASSERT_EQ(midair_set(of.scene, "cycle", "3"), MIDAIR_OK);
    EXPECT_EQ(Solved(of.scene).status, MIDAIR_FAILED);
    ASSERT_EQ(midair_set(of.scene, "cycle", "1"), MIDAIR_OK);

    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
    midair_field* newest = nullptr;
    EXPECT_TRUE(eventually(
        [&]
        {
            midair_update(of.scene, 0.0);
            return midair_newest_field(of.scene, &newest) == MIDAIR_SILENT;
        }));
    EXPECT_NE(std::string(midair_last_error()).find("not today"), std::string::npos)
        << midair_last_error();
    EXPECT_NE(of.messages().find("solver \"fails\" has failed: not today"), std::string::npos)
        << of.messages();
    EXPECT_EQ(midair_field_close(newest), MIDAIR_OK);
}

TEST(CExtend, OwnHandsReachThePoint)
{
    static int mode = 0;
    midair_hand_source source{};
    source.struct_size = sizeof source;
    source.user = &mode;
    source.open = openStill;
    source.hands = stillHands;
    ASSERT_EQ(midair_register_hands("still", &source), MIDAIR_OK) << midair_last_error();
    EXPECT_EQ(midair_register_hands("openxr", &source), MIDAIR_REFUSED);
    Focus of;
    ASSERT_EQ(midair_set(of.scene, "reach", "20 mm"), MIDAIR_OK);
    EXPECT_EQ(midair_open_hands(of.scene, "still:none"), MIDAIR_REFUSED);
    EXPECT_NE(std::string(midair_last_error()).find("no hands there"), std::string::npos);
    EXPECT_EQ(Solved(of.scene).status, MIDAIR_SILENT) << "no hand is near";
    ASSERT_EQ(midair_open_hands(of.scene, "still:"), MIDAIR_OK) << midair_last_error();
    EXPECT_EQ(Solved(of.scene).status, MIDAIR_OK);
    for (mode = 1; mode <= 3; ++mode)
        EXPECT_EQ(Solved(of.scene).status, MIDAIR_SILENT) << mode;
    EXPECT_NE(of.messages().find("a tracker"), std::string::npos) << of.messages();
    mode = 0;
    ASSERT_EQ(midair_open_hands(of.scene, "none"), MIDAIR_OK);
    EXPECT_EQ(Solved(of.scene).status, MIDAIR_SILENT);
}
