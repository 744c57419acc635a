#include "demo/window/sandbox_window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "demo/overlay/paint.h"
#include "demo/player/screen.h"
#include "demo/window/commands.h"
#include "demo/window/fly_camera.h"
#include "demo/window/foot_steps.h"
#include "demo/window/input_script.h"
#include "demo/window/path_brush.h"
#include "tilth/gl/api.h"
#include "tilth/io/png.h"

namespace tilth::demo {

namespace {

constexpr std::pair<int, Key> kKeys[] = {{GLFW_KEY_W, Key::W},
                                         {GLFW_KEY_A, Key::A},
                                         {GLFW_KEY_S, Key::S},
                                         {GLFW_KEY_D, Key::D},
                                         {GLFW_KEY_Q, Key::Q},
                                         {GLFW_KEY_E, Key::E},
                                         {GLFW_KEY_LEFT_SHIFT, Key::Shift},
                                         {GLFW_KEY_LEFT_CONTROL, Key::Control},
                                         {GLFW_KEY_RIGHT_CONTROL, Key::Control},
                                         {GLFW_KEY_1, Key::Digit1},
                                         {GLFW_KEY_2, Key::Digit2},
                                         {GLFW_KEY_3, Key::Digit3},
                                         {GLFW_KEY_4, Key::Digit4},
                                         {GLFW_KEY_5, Key::Digit5},
                                         {GLFW_KEY_6, Key::Digit6},
                                         {GLFW_KEY_7, Key::Digit7},
                                         {GLFW_KEY_8, Key::Digit8},
                                         {GLFW_KEY_9, Key::Digit9},
                                         {GLFW_KEY_LEFT_BRACKET, Key::BracketLeft},
                                         {GLFW_KEY_RIGHT_BRACKET, Key::BracketRight},
                                         {GLFW_KEY_X, Key::X},
                                         {GLFW_KEY_R, Key::R},
                                         {GLFW_KEY_T, Key::T},
                                         {GLFW_KEY_G, Key::G},
                                         {GLFW_KEY_Y, Key::Y},
                                         {GLFW_KEY_Z, Key::Z},
                                         {GLFW_KEY_F1, Key::F1},
                                         {GLFW_KEY_F2, Key::F2},
                                         {GLFW_KEY_F3, Key::F3},
                                         {GLFW_KEY_F4, Key::F4},
                                         {GLFW_KEY_F5, Key::F5},
                                         {GLFW_KEY_F6, Key::F6},
                                         {GLFW_KEY_F7, Key::F7},
                                         {GLFW_KEY_F12, Key::F12},
                                         {GLFW_KEY_ESCAPE, Key::Escape}};

/// Polls GLFW and turns it into `Input`: what changed since the frame before.
class InputPoller {
public:
    explicit InputPoller(GLFWwindow* window) : window_(window), time_s_(glfwGetTime()) {
        glfwSetWindowUserPointer(window, this);
        glfwSetScrollCallback(window, [](GLFWwindow* w, double, double notches) {
            static_cast<InputPoller*>(glfwGetWindowUserPointer(w))->wheel_ += notches;
        });
        glfwGetCursorPos(window, &x_, &y_);
    }
    ~InputPoller() {
        glfwSetScrollCallback(window_, nullptr);
        glfwSetWindowUserPointer(window_, nullptr);
    }

    Input poll() {
        glfwPollEvents();
        Input input;
        for (const auto& [code, key] : kKeys) {
            if (glfwGetKey(window_, code) != GLFW_PRESS) continue;
            input.held.insert(key);
            if (!held_.contains(key)) input.pressed.push_back(key);
        }
        held_ = input.held;
        double x = 0, y = 0;
        glfwGetCursorPos(window_, &x, &y);
        input.mouse_dx = std::exchange(x_, x), input.mouse_dx = x - input.mouse_dx;
        input.mouse_dy = std::exchange(y_, y), input.mouse_dy = y - input.mouse_dy;
        input.wheel = std::exchange(wheel_, 0.0);
        input.left_down = glfwGetMouseButton(window_, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS;
        input.left_pressed = input.left_down && !left_;
        left_ = input.left_down;
        input.right_down = glfwGetMouseButton(window_, GLFW_MOUSE_BUTTON_RIGHT) == GLFW_PRESS;
        const double now_s = glfwGetTime();
        input.dt_s = std::min(0.1, now_s - std::exchange(time_s_, now_s));
        return input;
    }
    /// Pixels of the framebuffer, which may be finer than the window's units.
    [[nodiscard]] std::pair<double, double> cursor() const {
        int window_width = 1, window_height = 1, width = 1, height = 1;
        glfwGetWindowSize(window_, &window_width, &window_height);
        glfwGetFramebufferSize(window_, &width, &height);
        return {x_ * width / std::max(window_width, 1), y_ * height / std::max(window_height, 1)};
    }

private:
    GLFWwindow* window_;
    double x_ = 0, y_ = 0, wheel_ = 0, time_s_;
    bool left_ = false;
    std::set<Key> held_;
};

const char* rule_name(StampRule rule) {
    constexpr const char* kNames[] = {"add", "min", "max", "set", "smooth"};
    return kNames[static_cast<std::size_t>(rule)];
}

/// One running sandbox. The detail map's tiles are kept about the camera.
class Sandbox {
public:
    Sandbox(GLFWwindow* window, Terrain& terrain, const WindowSettings& settings, std::unique_ptr<gl::Device> device)
        : window_(window),
          terrain_(terrain),
          settings_(settings),
          device_(std::move(device)),
          poller_(window),
          camera_(FlyCamera::looking(settings.start.eye, settings.start.forward)),
          asked_(settings.shown),
          shows_(settings.shown) {
        const double spacing_m = terrain.ground().settings().spacing_m;
        // Smaller than two posts, the coarse map cannot show a stamp.
        coarse_from_m_ = terrain.ground().settings().detail ? 2 * spacing_m : 0;
        const double texel_m = terrain.ground().map(MapKind::Detail).grid.spacing_m;
        least_radius_m_ = coarse_from_m_ > 0 ? 3 * texel_m : 2 * spacing_m, most_radius_m_ = 500 * spacing_m;
        boots_ = boots_for(texel_m);
        brush_.radius_m = 8 * spacing_m, brush_.depth_m = 0.2 * brush_.radius_m;
        glfwGetFramebufferSize(window, &width_, &height_);
        pixel_x_ = width_ / 2.0, pixel_y_ = height_ / 2.0;
    }

    Result<void> run() {
        std::cout << help_text() << std::flush;
        for (long frame = 0; glfwWindowShouldClose(window_) == GLFW_FALSE; ++frame) {
            if (settings_.frames > 0 && frame >= settings_.frames) break;
            if (const Result<void> done = step(frame); !done) return done.error();
        }
        return {};
    }

private:
    Result<void> step(long frame) {
        const Input input = read_input(frame);
        const Commands commands = commands_of(input, speed_m_per_s());
        brush_ = changed(brush_, input, terrain_.shapes().size(), least_radius_m_, most_radius_m_);
        glfwGetFramebufferSize(window_, &width_, &height_);
        if (commands.walk) toggle_walk();
        if (commands.overlay) shows_map_ = !shows_map_;
        show(changed(asked_, input));
        move(commands);
        aim();
        if (commands.teleport) teleport();
        stamp(commands);
        turn_back(commands);
        if (commands.save) terrain_.begin_save();
        const WorldPos viewer = place();
        terrain_.set_viewers({&viewer, 1});
        if (const auto updated = terrain_.update(input.dt_s); !updated) return updated.error();
        if (const auto drawn = draw(); !drawn) return drawn.error();
        if (commands.help) {
            std::cout << help_text() << std::flush;
            shows_help_ = !shows_help_;
        }
        if (commands.screenshot)
            if (const auto saved = save_screenshot(); !saved) std::cerr << saved.error().message << std::endl;
        for (const Error& trouble : terrain_.take_errors()) std::cerr << trouble.message << std::endl;
        std::ignore = terrain_.take_arrivals();
        if (commands.quit) glfwSetWindowShouldClose(window_, GLFW_TRUE);
        glfwSwapBuffers(window_);
        show_title(input.dt_s);
        return {};
    }

    Input read_input(long frame) {
        const Input polled = poller_.poll();
        if (!settings_.script) {
            std::tie(pixel_x_, pixel_y_) = poller_.cursor();
            return polled;
        }
        const Input scripted = scripted_input(frame);
        pixel_x_ += scripted.mouse_dx, pixel_y_ += scripted.mouse_dy;
        return scripted;
    }

    /// Walking pace near the ground, faster from high above.
    [[nodiscard]] double speed_m_per_s() const {
        const double above_m = camera_.eye.y - ground_m(place());
        return std::clamp(above_m, 4.0, 400.0);
    }

    /// As the CPU knows it: a frame waits neither for the GPU nor for a tile.
    [[nodiscard]] double ground_m(WorldPos at) const { return terrain_.ground().height_m(at); }

    [[nodiscard]] WorldPos place() const { return {camera_.eye.x, camera_.eye.z}; }

    /// What the context cannot do is told, and passed over: the key goes on to the next.
    void show(const ShownDetail& wanted) {
        if (wanted == asked_) return;
        if (const auto set = terrain_.set_detail(settings_of(wanted)); !set)
            std::cerr << set.error().message << std::endl;
        else
            shows_ = wanted;
        asked_ = wanted;
    }

    void toggle_walk() {
        const auto boot = terrain_.shapes().find("boot");
        if (!boot || coarse_from_m_ == 0) {
            std::cerr << "G: there are no prints without a detail map and a stamp named boot\n";
            return;
        }
        boot_ = *boot;
        walks_ = !walks_;
        steps_.stop();
        begin_or_end_stroke(walks_ || draws_);
    }

    /// Undone together: what a drag lays, and what a walk leaves between drags.
    void begin_or_end_stroke(bool begin) {
        if (begin)
            terrain_.begin_stroke();
        else
            terrain_.end_stroke();
    }

    void turn_back(const Commands& commands) {
        if (commands.undo)
            if (const auto undone = terrain_.undo(); !undone) std::cerr << undone.error().message << std::endl;
        if (commands.redo)
            if (const auto redone = terrain_.redo(); !redone) std::cerr << redone.error().message << std::endl;
    }

    void move(const Commands& commands) {
        if (!walks_) {
            camera_ = moved(camera_, commands);
            return;
        }
        camera_ = walked(camera_, commands);
        camera_.eye.y = ground_m(place()) + boots_.eye_m;
        for (const StampRequest& print : steps_.step(place(), boots_, boot_))
            if (const auto made = terrain_.stamp(print); !made) std::cerr << made.error().message << std::endl;
    }

    /// To where the cursor points, at the height above the ground that the viewer has now.
    void teleport() {
        const double above_m = camera_.eye.y - ground_m(place());
        const WorldPos to = aim_ ? *aim_ : far_corner(terrain_.ground().map(MapKind::Coarse).grid, place());
        camera_.eye = {to.x, ground_m(to) + above_m, to.z};
        steps_.stop();
        aim();
    }

    [[nodiscard]] View view() const {
        ViewPart part = settings_.view;
        part.width = width_, part.height = height_;
        const double above_m = camera_.eye.y - ground_m(place());
        return view_of({camera_.eye, camera_.forward()}, part, above_m);
    }

    /// Where the cursor's ray hits the ground.
    void aim() {
        aim_.reset();
        if (width_ <= 0 || height_ <= 0) return;
        const Vec3d direction = ray_through(view(), camera_.right(), pixel_x_, pixel_y_);
        const auto distance_m = terrain_.raycast(camera_.eye, direction, 50'000);
        if (!distance_m) return;
        const double length =
            std::sqrt(direction.x * direction.x + direction.y * direction.y + direction.z * direction.z);
        const double share = *distance_m / length;
        aim_ = WorldPos{camera_.eye.x + direction.x * share, camera_.eye.z + direction.z * share};
        aim_height_m_ = camera_.eye.y + direction.y * share;
    }

    void stamp(const Commands& commands) {
        const bool draws = commands.stamp || commands.drag;
        if (commands.stamp || draws != draws_) begin_or_end_stroke(draws || walks_);
        draws_ = draws;
        if (!draws) path_.release();
        if (!aim_ || !draws) return;
        const auto due = commands.stamp ? path_.press(*aim_) : path_.drag(*aim_, brush_.radius_m / 2);
        if (commands.stamp) stroke_height_m_ = aim_height_m_;
        for (const WorldPos& at : due) {
            StampRequest request = stamp_of(brush_, at, stroke_height_m_, coarse_from_m_);
            request.shape = {static_cast<std::uint32_t>(brush_.shape)};
            if (const auto made = terrain_.stamp(request); !made) std::cerr << made.error().message << std::endl;
        }
    }

    Result<void> draw() {
        if (width_ <= 0 || height_ <= 0) return {};  // minimised
        const gl::Api& gl = device_->gl();
        const Vec3f& clear = settings_.view.clear;
        gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
        gl.Viewport(0, 0, width_, height_);
        gl.ClearColor(clear.x, clear.y, clear.z, 1);
        gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        const Shading shading = shading_of(settings_.view, settings_.low_m, settings_.high_m);
        const BrushCursor cursor{.centre = aim_.value_or(WorldPos{}), .radius_m = brush_.radius_m};
        if (const auto drawn = terrain_.draw(view(), shading, aim_ ? &cursor : nullptr); !drawn) return drawn.error();
        paint_map();
        return {};
    }

    /// Into the framebuffer that is bound, where the user wants it.
    void paint_map() {
        const WorldPos viewer = place();
        if (shows_map_) paint(*device_, residency_map(terrain_, {&viewer, 1}, width_, height_), height_);
    }

    /// The same view drawn off screen: a window's pixels may be covered by another.
    Result<void> save_screenshot() {
        ViewPart part = settings_.view;
        part.width = width_, part.height = height_;
        auto target = OffscreenTarget::create(*device_, width_, height_);
        if (!target) return target.error();
        target->begin(part.clear);
        const Shading shading = shading_of(part, settings_.low_m, settings_.high_m);
        if (const auto drawn = terrain_.draw(view(), shading); !drawn) return drawn.error();
        paint_map();
        const std::string path = (settings_.out / ("screenshot-" + std::to_string(++screenshots_) + ".png")).string();
        if (const auto written = io::write_png_rgb8(path, width_, height_, target->read_rgb8()); !written)
            return written.error();
        std::cout << path << std::endl;
        return {};
    }

    void show_title(double dt_s) {
        smooth_dt_s_ = smooth_dt_s_ == 0 ? dt_s : 0.95 * smooth_dt_s_ + 0.05 * dt_s;
        const gl::FrameStats& stats = terrain_.last_frame();
        const std::vector<TileReport> tiles = terrain_.tiles();
        const auto resident = std::count_if(tiles.begin(), tiles.end(),
                                            [](const TileReport& tile) { return tile.state == TileState::Resident; });
        char line[500];
        std::snprintf(
            line, sizeof line,
            "tilth  %.1f ms  %llu k triangles  %llu deform passes  %lld of %zu tiles resident, %llu loaded  |  "
            "%s%s %s %s, radius %.1f m  |  %s  |  %s",
            smooth_dt_s_ * 1e3, static_cast<unsigned long long>(stats.render.primitives / 1000),
            static_cast<unsigned long long>(stats.deform.passes), static_cast<long long>(resident), tiles.size(),
            static_cast<unsigned long long>(terrain_.total().cache.loads), walks_ ? "on foot, " : "",
            terrain_.shapes().shape({static_cast<std::uint32_t>(brush_.shape)}).name.c_str(), rule_name(brush_.rule),
            brush_.digs ? "down" : "up", brush_.radius_m, title_of(shows_).c_str(),
            shows_help_ ? "WASD QE move, right button looks, left stamps, wheel radius, 1-9 [ ] stamp, X "
                          "sign, R rule, G walk, T teleport, Ctrl+Z undo, F2 map, F3 F4 F6 F7 detail, F12 picture, Esc"
                        : "F1 help");
        glfwSetWindowTitle(window_, line);
    }

    GLFWwindow* window_;
    Terrain& terrain_;
    const WindowSettings& settings_;
    std::unique_ptr<gl::Device> device_;
    InputPoller poller_;
    FlyCamera camera_;
    Brush brush_;
    PathBrush path_;
    std::optional<WorldPos> aim_;
    double aim_height_m_ = 0, stroke_height_m_ = 0;
    double least_radius_m_ = 1, most_radius_m_ = 100;
    double coarse_from_m_ = 0;  ///< radius from which on the brush works on the coarse map; 0: always
    FootSteps steps_;
    BootSize boots_;
    ShapeId boot_;
    bool walks_ = false, shows_map_ = false;
    ShownDetail asked_, shows_;  ///< asked for; what is shown
    bool draws_ = false;         ///< the button was down in the frame before
    double pixel_x_ = 0, pixel_y_ = 0, smooth_dt_s_ = 0;
    int width_ = 0, height_ = 0, screenshots_ = 0;
    bool shows_help_ = false;
};

}  // namespace

Result<void> run_window(GLFWwindow* window, Terrain& terrain, const WindowSettings& settings) {
    auto device =
        gl::Device::create([](const char* name) { return reinterpret_cast<void*>(glfwGetProcAddress(name)); });
    if (!device) return device.error();
    return Sandbox(window, terrain, settings, std::move(*device)).run();
}

}  // namespace tilth::demo
