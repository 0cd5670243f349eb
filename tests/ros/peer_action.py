#!/usr/bin/env python3
"""Sends an action a goal with rclpy's own action client, as `ros2 action send_goal --feedback` does.

    peer_action.py --domain 0 /auv/depth_controller/manoeuvre planesman_msgs/action/Manoeuvre \\
        --json '{"name": "run_8_1"}' --cancel-after 3

Prints what ../peers/peer_action.py prints: one JSON line when the goal is accepted or rejected, one for each feedback, and
one for its end, with the states that the status topic gave it. Exit status 1: the node did not answer within --timeout
seconds. 3: rejected.
"""

import math
import sys
import time
from collections import deque

import ros
import arguments
from action_msgs.msg import GoalStatus, GoalStatusArray
from rclpy.action import ActionClient

REJECTED = 3

NAMES = {
    getattr(GoalStatus, name): name.removeprefix("STATUS_") for name in dir(GoalStatus) if name.startswith("STATUS_")
}
"""GoalStatus' number -> `SUCCEEDED` and so on."""


def main() -> int:
    args = arguments.action(__doc__)
    kind = ros.interface(args.type)
    request = ros.fill(kind.Goal(), args.json)
    feedback: deque = deque()

    with ros.node(args.domain) as node:
        states: dict[bytes, list[str]] = {}

        def hear(message: GoalStatusArray) -> None:
            for status in message.status_list:
                seen = states.setdefault(bytes(status.goal_info.goal_id.uuid), [])
                if seen[-1:] != [NAMES[status.status]]:
                    seen.append(NAMES[status.status])

        qos = ros.topic_qos(durability="transient_local", depth=100)
        node.create_subscription(GoalStatusArray, f"{args.action}/_action/status", hear, qos)
        client = ActionClient(node, kind, args.action)

        def answer(future):
            if not ros.spin_until(node, future.done, args.timeout):
                raise ros.NoAnswer(f"{args.action}: no answer within {args.timeout:g} s")
            return future.result()

        try:
            if not client.wait_for_server(args.timeout):
                raise ros.NoAnswer(f"{args.action}: not served within {args.timeout:g} s")
            goal = answer(client.send_goal_async(request, feedback_callback=lambda told: feedback.append(told.feedback)))
            arguments.show(accepted=goal.accepted)
            if not goal.accepted:
                return REJECTED
            result = goal.get_result_async()
            cancel_at = time.monotonic() + (math.inf if args.cancel_after is None else args.cancel_after)

            def ended() -> bool:
                while feedback:
                    arguments.show(feedback=ros.to_json(feedback.popleft()))
                return result.done() or time.monotonic() >= cancel_at

            ros.spin_until(node, ended, args.timeout)
            if not result.done() and time.monotonic() >= cancel_at:
                # `ros2 action send_goal` cancels on Ctrl-C only a goal whose handle says that it is under way.
                handle = NAMES[goal.status]
                arguments.show(cancel=answer(goal.cancel_goal_async()).return_code, handle=handle)
                cancel_at = math.inf
            if not ros.spin_until(node, ended, args.timeout):
                raise ros.NoAnswer(f"{args.action}: no result within {args.timeout:g} s")
            end = result.result()
            seen = states.setdefault(bytes(goal.goal_id.uuid), [])
            ros.spin_until(node, lambda: seen[-1:] == [NAMES[end.status]], 5.0)
            arguments.show(status=NAMES[end.status], result=ros.to_json(end.result), statuses=seen)
        except ros.NoAnswer as failure:
            print(failure, file=sys.stderr)
            return 1
        finally:
            client.destroy()
    return 0


if __name__ == "__main__":
    sys.exit(main())
