using System;
using System.Collections.Generic;
using System.Reflection;

namespace UnityEngine
{
    /// <summary>Time of the game.</summary>
    public static class Time
    {
        /// <summary>Seconds since it began.</summary>
        public static double unscaledTimeAsDouble
        {
            get { return Engine.NowS; }
        }
    }

    /// <summary>The console.</summary>
    public static class Debug
    {
        /// <summary>An error, with the object that it belongs to.</summary>
        public static void LogError(object message, Object context)
        {
            Engine.Errors.Add(message.ToString());
        }

        /// <summary>An exception, with the object that it belongs to.</summary>
        public static void LogException(Exception exception, Object context)
        {
            Engine.Errors.Add(exception.ToString());
        }
    }

    /// <summary>Calls scripts as Unity documents it: OnEnable, then each frame every Update before
    /// any LateUpdate, each by execution order.</summary>
    public static class Engine
    {
        private static readonly List<MonoBehaviour> Scripts = new List<MonoBehaviour>();

        /// <summary>What the console shows.</summary>
        public static List<string> Errors { get; } = new List<string>();

        /// <summary>The time of the frame, seconds.</summary>
        public static double NowS { get; private set; }

        /// <summary>Let scripts run.</summary>
        public static void Enable(params MonoBehaviour[] scripts)
        {
            foreach (MonoBehaviour script in scripts)
            {
                Scripts.Add(script);
                script.isActiveAndEnabled = true;
                Call(script, "OnEnable");
            }
            Scripts.Sort((a, b) => Order(a).CompareTo(Order(b)));
        }

        /// <summary>Stop all scripts.</summary>
        public static void DisableAll()
        {
            foreach (MonoBehaviour script in Scripts)
            {
                script.isActiveAndEnabled = false;
                Call(script, "OnDisable");
            }
            Scripts.Clear();
        }

        /// <summary>One frame.</summary>
        public static void Frame(double periodS)
        {
            NowS += periodS;
            foreach (string phase in new[] { "Update", "LateUpdate" })
            {
                foreach (MonoBehaviour script in Scripts)
                {
                    Call(script, phase);
                }
            }
        }

        /// <summary>A message of the engine, such as OnApplicationPause.</summary>
        public static void Call(MonoBehaviour script, string message, params object[] arguments)
        {
            MethodInfo method = script.GetType().GetMethod(
                message, BindingFlags.Instance | BindingFlags.NonPublic | BindingFlags.Public);
            try
            {
                method?.Invoke(script, arguments);
            }
            catch (TargetInvocationException error)
            {
                Errors.Add(error.InnerException.ToString());
            }
        }

        private static int Order(MonoBehaviour script)
        {
            object[] found = script.GetType().GetCustomAttributes(
                typeof(DefaultExecutionOrderAttribute), false);
            return found.Length == 0 ? 0 : ((DefaultExecutionOrderAttribute)found[0]).Order;
        }
    }
}
