// Corrects joint positions by a calibration's correction.json.
//
// A URDF holds joint origins; it cannot say that an encoder errs with its position, or that a joint deflects under a
// torque. correction.json, beside calibrated.urdf, does:
//
//     const auto correction = touchcal::Correction::read("out/correction.json");
//     const auto q = correction.true_positions(measured);        // positions for calibrated.urdf
//     const auto command = correction.commanded_positions(plan); // of positions that were planned with calibrated.urdf
//
// C++17 and its standard library alone: this file and correction_json.hpp may be copied. A correction does not change
// after it is read, so threads may share it. Errors are of type CorrectionError. The same for Python is
// python/touchcal/correction.py.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "correction_json.hpp"

namespace touchcal {

namespace detail {

using Vector = std::array<double, 3>;

inline Vector operator+(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vector operator-(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vector operator*(double s, const Vector& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// A rotation: the rows of its matrix.
struct Rotation {
    std::array<Vector, 3> rows{Vector{1, 0, 0}, Vector{0, 1, 0}, Vector{0, 0, 1}};

    static Rotation of_quaternion(double w, const Vector& v) {
        const auto [x, y, z] = v;
        Rotation rotation;
        rotation.rows[0] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)};
        rotation.rows[1] = {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)};
        rotation.rows[2] = {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)};
        return rotation;
    }

    static Rotation about(const Vector& axis, double angle) {
        return of_quaternion(std::cos(0.5 * angle), std::sin(0.5 * angle) * axis);
    }

    Vector operator*(const Vector& v) const { return {dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)}; }

    Rotation operator*(const Rotation& other) const {
        Rotation product;
        for (std::size_t i = 0; i < 3; ++i) {
            product.rows[i] = rows[i][0] * other.rows[0] + rows[i][1] * other.rows[1] + rows[i][2] * other.rows[2];
        }
        return product;
    }
};

// What moves with a joint, or the tip.
struct Link {
    Vector translation{};
    Rotation rotation;
    double mass = 0.0;
    Vector center{};

    static Link read(const Json& entry) {
        const Json& pose = entry.at("parent_from_joint");
        const auto [w, x, y, z] = pose.at("quat_wxyz").as_numbers<4>();
        if (!(std::abs(w * w + x * x + y * y + z * z - 1.0) < 1e-9)) throw CorrectionError("expected a unit quaternion");
        return {pose.at("xyz_m").as_numbers<3>(), Rotation::of_quaternion(w, {x, y, z}), entry.at("mass_kg").as_number(),
                entry.at("center_m").as_numbers<3>()};
    }
};

struct Harmonic {
    int order = 1;
    double sine = 0.0;
    double cosine = 0.0;

    static Harmonic read(const Json& entry) {
        const double order = entry.at("order").as_number();
        if (order != 1.0 && order != 2.0) throw CorrectionError("expected a harmonic of order 1 or 2");
        return {static_cast<int>(order), entry.at("sin").as_number(), entry.at("cos").as_number()};
    }
};

struct Joint {
    std::string name;
    bool turns = true;
    double offset = 0.0;
    double gear_ratio = 0.0;
    std::vector<Harmonic> harmonics;
    double compliance = 0.0;
    double backlash = 0.0;
    Vector axis{};
    Link link;

    static Joint read(const Json& entry) {
        Joint joint;
        joint.name = entry.at("name").as_text();
        const std::string& kind = entry.at("kind").as_text();
        if (kind != "revolute" && kind != "prismatic") throw CorrectionError("expected revolute or prismatic, found " + kind);
        joint.turns = kind == "revolute";
        joint.offset = entry.at("offset_in_urdf").as_number();
        joint.gear_ratio = entry.at("gear_ratio").as_number();
        for (const Json& harmonic : entry.at("harmonics").as_list()) joint.harmonics.push_back(Harmonic::read(harmonic));
        joint.compliance = entry.at("compliance_rad_per_nm").as_number();
        joint.backlash = entry.at("backlash").as_number();
        joint.axis = entry.at("axis").as_numbers<3>();
        if (!(std::abs(dot(joint.axis, joint.axis) - 1.0) < 1e-9)) throw CorrectionError("expected a unit vector as axis");
        joint.link = Link::read(entry);
        return joint;
    }

    // Whether any torque moves the joint.
    bool deflects() const { return compliance != 0.0 || backlash != 0.0; }

    // How far a torque moves the joint.
    double deflection(double torque, double backlash_torque) const {
        return compliance * torque + backlash * torque / std::hypot(torque, backlash_torque);
    }

    // Measured less true position where the encoder measures q.
    double error(double q) const {
        double error = -gear_ratio * q;
        for (const auto& [n, sine, cosine] : harmonics) error += sine * std::sin(n * q) + cosine * std::cos(n * q);
        return error;
    }

    // Derivative of the error by q.
    double slope(double q) const {
        double slope = -gear_ratio;
        for (const auto& [n, sine, cosine] : harmonics) slope += n * (sine * std::cos(n * q) - cosine * std::sin(n * q));
        return slope;
    }

    // The position that the encoder measures at q, by Newton's method.
    double measured(double q) const {
        double measured = q;
        for (int step_number = 0; step_number < 50; ++step_number) {
            const double remaining = 1.0 - slope(measured);
            if (!(remaining > 0.0)) break;
            const double step = (measured - error(measured) - q) / remaining;
            measured -= step;
            if (std::abs(step) <= 1e-14 * std::max(1.0, std::abs(measured))) return measured;
        }
        throw CorrectionError("no measured position belongs to a wanted one: the errors of the encoder are too large");
    }
};

} // namespace detail

// The wrench fx, fy, fz, tx, ty, tz (N, N m) that is exerted on the tip about its origin, in its frame.
using Load = std::array<double, 6>;

// Measured torques (N m, or N of a prismatic joint), one for each joint, base first, that gravity and contact exert about
// the joints: the negative of what the motors exert.
struct Tau {
    std::vector<double> torques;
};

// Corrections of the positions of an arm's joints: rad, or m for a prismatic joint, base first. Positions of revolute
// joints beyond two turns are refused, since they look like degrees.
class Correction {
public:
    // From the content of correction.json. That of a calibration that must not be used is refused, unless not_usable.
    //
    explicit Correction(const std::string& text, bool not_usable = false) {
        const detail::Json content = detail::JsonReader(text).read();
        if (content.at("schema").as_number() != 1.0) throw CorrectionError("expected schema 1");
        status_ = content.at("status").as_text();
        if (status_ != "usable" && status_ != "doubtful" && status_ != "not_usable") throw CorrectionError("expected a status");
        if (status_ == "not_usable" && !not_usable) throw CorrectionError("the calibration must not be used: status not_usable");
        const std::string& torque = content.at("torque").as_text();
        if (torque != "gravity_and_load" && torque != "measured") throw CorrectionError("expected a kind of torque");
        has_measured_torques_ = torque == "measured";
        backlash_torque_ = content.at("backlash_torque").as_number();
        if (!(backlash_torque_ > 0.0)) throw CorrectionError("expected a backlash_torque above 0");
        gravity_ = content.at("gravity_m_s2").as_numbers<3>();
        for (const detail::Json& joint : content.at("joints").as_list()) joints_.push_back(detail::Joint::read(joint));
        if (joints_.empty()) throw CorrectionError("expected at least one joint");
        tip_ = detail::Link::read(content.at("tip_link"));
    }

    // Reads the file.
    static Correction read(const std::string& path, bool not_usable = false) {
        std::ifstream file(path, std::ios::binary);
        std::ostringstream text;
        text << file.rdbuf();
        if (!file) throw CorrectionError(path + ": cannot be read");
        return Correction(text.str(), not_usable);
    }

    // usable, doubtful or not_usable.
    const std::string& status() const { return status_; }

    std::size_t size() const { return joints_.size(); }

    // Name of a joint, from 0 at the base.
    const std::string& name(std::size_t joint) const { return joints_.at(joint).name; }

    // Encoder offset of a joint, measured less true position, which calibrated.urdf contains.
    double offset(std::size_t joint) const { return joints_.at(joint).offset; }

    // Whether joints deflect by measured torques, in place of those of gravity and a load.
    bool has_measured_torques() const { return has_measured_torques_; }

    // Positions for calibrated.urdf where the encoders measure these. Where joints deflect by measured torques, Tau is
    // needed; elsewhere it is refused.
    std::vector<double> true_positions(const std::vector<double>& measured, const Load& load = {}) const {
        check(measured);
        const std::vector<double> stiff = without_errors(measured);
        if (!is_compliant()) return stiff;
        if (has_measured_torques_) throw CorrectionError("expected Tau, measured torques of the joints, in place of a load");
        std::vector<double> positions = stiff;
        for (int iteration = 0; iteration < 50; ++iteration) {
            const std::vector<double> torques = torques_at(positions, load);
            double change = 0.0;
            for (std::size_t i = 0; i < size(); ++i) {
                const double deflected = stiff[i] + deflection(i, torques[i]);
                change = std::max(change, std::abs(deflected - positions[i]));
                positions[i] = deflected;
            }
            if (change <= 1e-13) return positions;
        }
        throw CorrectionError("the joints do not come to rest: they are too compliant for what they carry");
    }

    std::vector<double> true_positions(const std::vector<double>& measured, const Tau& tau) const {
        check(measured);
        check_numbers(tau.torques);
        std::vector<double> positions = without_errors(measured);
        if (!is_compliant()) return positions;
        if (!has_measured_torques_) throw CorrectionError("expected no Tau: the joints of this file deflect by gravity and load");
        for (std::size_t i = 0; i < size(); ++i) positions[i] += deflection(i, tau.torques[i]);
        return positions;
    }

    // Positions to command so that the joints are at these positions of calibrated.urdf.
    std::vector<double> commanded_positions(const std::vector<double>& wanted, const Load& load = {}) const {
        check(wanted);
        if (is_compliant() && has_measured_torques_) {
            throw CorrectionError("expected a file of gravity and load, found measured torques: what the joints deflect by "
                                  "is not known before the arm is there, so that nothing can be commanded");
        }
        for (const detail::Joint& joint : joints_) {
            if (joint.backlash != 0.0) {
                throw CorrectionError("expected a file without backlash, found one with it: what the joints deflect by is "
                                      "not known before the arm is there, so that nothing can be commanded");
            }
        }
        const std::vector<double> torques = is_compliant() ? torques_at(wanted, load) : std::vector<double>(size(), 0.0);
        std::vector<double> commanded(size());
        for (std::size_t i = 0; i < size(); ++i) {
            commanded[i] = joints_[i].measured(wanted[i] - deflection(i, torques[i]));
        }
        return commanded;
    }

    // Torque (N m) of gravity and load about each joint at true positions; of a prismatic one the force (N).
    std::vector<double> torques(const std::vector<double>& positions, const Load& load = {}) const {
        check(positions);
        return torques_at(positions, load);
    }

private:
    std::vector<double> torques_at(const std::vector<double>& positions, const Load& load) const {
        using namespace detail;
        std::vector<Vector> axes(size()), origins(size()), moments(size());
        Rotation rotation;
        Vector origin{};
        for (std::size_t i = 0; i < size(); ++i) {
            const Joint& joint = joints_[i];
            origin = origin + rotation * joint.link.translation;
            rotation = rotation * joint.link.rotation;
            axes[i] = rotation * joint.axis;
            origins[i] = origin;
            if (joint.turns) {
                rotation = rotation * Rotation::about(joint.axis, positions[i]);
            } else {
                origin = origin + positions[i] * axes[i];
            }
            moments[i] = joint.link.mass * (rotation * joint.link.center + origin);
        }
        const Vector tip = origin + rotation * tip_.translation;
        rotation = rotation * tip_.rotation;
        double mass = tip_.mass;
        Vector moment = tip_.mass * (rotation * tip_.center + tip);
        const Vector force = rotation * Vector{load[0], load[1], load[2]};
        const Vector about_tip = rotation * Vector{load[3], load[4], load[5]};
        std::vector<double> torques(size(), 0.0);
        for (std::size_t i = size(); i-- > 0;) {
            mass += joints_[i].link.mass;
            moment = moment + moments[i];
            const Vector of_gravity = cross(moment - mass * origins[i], gravity_);
            torques[i] = joints_[i].turns ? dot(axes[i], of_gravity + cross(tip - origins[i], force) + about_tip)
                                          : dot(axes[i], mass * gravity_ + force);
        }
        return torques;
    }

    double deflection(std::size_t joint, double torque) const { return joints_[joint].deflection(torque, backlash_torque_); }

    bool is_compliant() const {
        for (const detail::Joint& joint : joints_) {
            if (joint.deflects()) return true;
        }
        return false;
    }

    // Measured positions less the errors of encoders.
    std::vector<double> without_errors(const std::vector<double>& measured) const {
        std::vector<double> positions = measured;
        for (std::size_t i = 0; i < size(); ++i) positions[i] -= joints_[i].error(measured[i]);
        return positions;
    }

    void check_numbers(const std::vector<double>& values) const {
        if (values.size() != size()) {
            throw CorrectionError("expected " + std::to_string(size()) + " numbers, found " + std::to_string(values.size()));
        }
        for (const double value : values) {
            if (!std::isfinite(value)) throw CorrectionError("expected finite numbers");
        }
    }

    void check(const std::vector<double>& positions) const {
        check_numbers(positions);
        const double two_turns = 4.0 * std::acos(-1.0);
        for (std::size_t i = 0; i < size(); ++i) {
            if (joints_[i].turns && std::abs(positions[i]) > two_turns) {
                throw CorrectionError("expected at most 12.566 rad of joint " + joints_[i].name +
                                      " (angles are radians), found " + std::to_string(positions[i]) + " rad");
            }
        }
    }

    std::string status_;
    bool has_measured_torques_ = false;
    double backlash_torque_ = 0.0;
    detail::Vector gravity_{};
    std::vector<detail::Joint> joints_;
    detail::Link tip_;
};

} // namespace touchcal
